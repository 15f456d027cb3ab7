"""Build of forest_msgs_py for colcon; pip users install the root pyproject.toml."""

from setuptools import find_packages, setup

package = "forest_msgs_py"

setup(
    name=package,
    version="0.3.0",
    description="How the nodes talk, live and on disk: topics, arrays, bags, pictures, the frame of a node",
    license="Apache-2.0",
    packages=find_packages(include=[package, f"{package}.*"]),
    package_data={package: ["py.typed", "*.xml"]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{package}"]),
        (f"share/{package}", ["package.xml"]),
    ],
    zip_safe=False,
)
