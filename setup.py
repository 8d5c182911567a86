from catkin_pkg.python_setup import generate_distutils_setup
from setuptools import setup

PACKAGES = ["voxnav", "voxnav.nodes", "voxnav.offline", "voxnav.demo", "voxnav.alignment",
            "voxnav.planning_manager"]

# Types for those who use the package: py.typed says that it has them, the stubs are those of the C++ modules.
setup(**generate_distutils_setup(packages=PACKAGES, package_dir={"": "src"},
                                 package_data={"voxnav": ["py.typed", "*.pyi"]}))
