"""Build of forest_station for colcon; pip users install the root pyproject.toml."""

from setuptools import find_packages, setup

package = "forest_station"

setup(
    name=package,
    version="0.3.0",
    description="The operator's page: the crane seen and driven in a browser",
    license="Apache-2.0",
    packages=find_packages(include=[package, f"{package}.*"]),
    package_data={package: ["py.typed", "web/*", "web/*/*"]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{package}"]),
        (f"share/{package}", ["package.xml"]),
        (f"share/{package}/launch", ["launch/station.launch.py"]),
    ],
    zip_safe=False,
    entry_points={"console_scripts": ["station_node = forest_station.station_node:main"]},
)
