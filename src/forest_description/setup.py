"""Build of forest_description for colcon; pip users install the root pyproject.toml."""

from setuptools import find_packages, setup

package = "forest_description"

setup(
    name=package,
    version="0.3.0",
    description="What the crane is: parameters, linkage, tip kinematics, static laws, URDF",
    license="Apache-2.0",
    packages=find_packages(include=[package, f"{package}.*"]),
    package_data={package: ["py.typed", "machines/*.yaml"]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{package}"]),
        (f"share/{package}", ["package.xml"]),
    ],
    zip_safe=False,
)
