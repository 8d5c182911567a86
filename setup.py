from catkin_pkg.python_setup import generate_distutils_setup
from setuptools import setup

PACKAGES = ["voxnav", "voxnav.nodes", "voxnav.offline", "voxnav.demo", "voxnav.alignment"]

setup(**generate_distutils_setup(packages=PACKAGES, package_dir={"": "src"}))
