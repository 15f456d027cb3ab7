"""Build of forest_control for colcon; pip users install the root pyproject.toml."""

from setuptools import find_packages, setup

package = "forest_control"

setup(
    name=package,
    version="0.3.0",
    description="How the operator's wish becomes voltage: joystick, schemes, valve driver, their nodes",
    license="Apache-2.0",
    packages=find_packages(include=[package, f"{package}.*"]),
    package_data={
        package: ["py.typed", "cycles/*.yaml", "joysticks/*.yaml", "profiles/*.yaml", "workspaces/*.yaml"]
    },
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{package}"]),
        (f"share/{package}", ["package.xml"]),
    ],
    zip_safe=False,
    entry_points={
        "console_scripts": [
            "forest-control = forest_control.cli.main:main",
            "cycle_node = forest_control.cycle_node:main",
            "twist_node = forest_control.twist_node:main",
            "joystick_node = forest_control.joystick_node:main",
            "controller_node = forest_control.controller_node:main",
            "valve_driver_node = forest_control.valve_driver_node:main",
        ]
    },
)
