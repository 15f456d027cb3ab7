"""Build of forest_viewers for colcon; pip users install the root pyproject.toml."""

from setuptools import find_packages, setup

package = "forest_viewers"
LAYOUTS = ("crane.rviz", "foxglove.json", "plotjuggler.xml", "qos_overrides.yaml")

setup(
    name=package,
    version="0.3.0",
    description="How other tools see the crane: transforms, markers, Foxglove, layouts",
    license="Apache-2.0",
    packages=find_packages(include=[package, f"{package}.*"]),
    package_data={package: ["py.typed", "layouts/*"]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{package}"]),
        (f"share/{package}", ["package.xml"]),
        (f"share/{package}/layouts", [f"{package}/layouts/{name}" for name in LAYOUTS]),
    ],
    zip_safe=False,
    entry_points={
        "console_scripts": [
            "forest-viewers = forest_viewers.cli:main",
            "foxglove_node = forest_viewers.foxglove_node:main",
            "viewer_node = forest_viewers.viewer_node:main",
        ]
    },
)
