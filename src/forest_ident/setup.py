"""Build of forest_ident for colcon; pip users install the root pyproject.toml."""

from setuptools import find_packages, setup

package = "forest_ident"

setup(
    name=package,
    version="0.3.0",
    description="What the records tell: the recorder and what learns from bags",
    license="Apache-2.0",
    packages=find_packages(include=[package, f"{package}.*"]),
    package_data={package: ["py.typed", "report/templates/*.html"]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{package}"]),
        (f"share/{package}", ["package.xml"]),
    ],
    zip_safe=False,
    entry_points={
        "console_scripts": [
            "experiment_operator_node = forest_ident.experiment_operator_node:main",
            "monitor_node = forest_ident.monitor_node:main",
            "online_identification_node = forest_ident.online_node:main",
            "recorder_node = forest_bag.recorder_node:main",
            "step_player_node = forest_bag.step_player_node:main",
        ]
    },
)
