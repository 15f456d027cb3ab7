"""Build of forest_bringup for colcon; pip users install the root pyproject.toml."""

from setuptools import find_packages, setup

package = "forest_bringup"

setup(
    name=package,
    version="0.3.0",
    description="What starts, watches and stops a graph of nodes",
    license="Apache-2.0",
    packages=find_packages(include=[package, f"{package}.*"]),
    package_data={package: ["py.typed"]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{package}"]),
        (f"share/{package}", ["package.xml"]),
        (f"share/{package}/launch", ["launch/graph.launch.py"]),
    ],
    zip_safe=False,
)
