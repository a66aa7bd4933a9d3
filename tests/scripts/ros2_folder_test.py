#!/usr/bin/env python3
"""What ros2/ holds, without ROS: XML, Python and YAML are read, and names are those of the bridge."""

import ast
import pathlib
import re
import unittest
import xml.etree.ElementTree

ROOT = pathlib.Path(__file__).resolve().parents[2]
PACKAGE = ROOT / "ros2/stof_description"
DRIVER = ROOT / "ros2/stof_driver"
XACRO = "{http://www.ros.org/wiki/xacro}"


class Ros2Folder(unittest.TestCase):
    def test_packages_have_the_version_and_name_of_the_project(self):
        version = re.search(r"project\(stof VERSION (\S+)", (ROOT / "CMakeLists.txt").read_text())[1]
        for folder in (PACKAGE, DRIVER):
            package = xml.etree.ElementTree.parse(folder / "package.xml").getroot()
            self.assertEqual(package.findtext("name"), folder.name)
            self.assertEqual(package.findtext("version"), version)
            self.assertTrue((folder / package.find("license").get("file")).resolve().is_file())
            rules = (folder / "CMakeLists.txt").read_text()
            self.assertRegex(rules, rf"project\({folder.name}\b")
            installed = re.search(r"install\(DIRECTORY ([\w ]+) DESTINATION", rules)[1].split()
            self.assertEqual(sorted(installed), sorted(path.name for path in folder.iterdir() if path.is_dir() and path.name != "src"))

    def test_the_drivers_rules_name_what_its_sources_include(self):
        rules = (DRIVER / "CMakeLists.txt").read_text()
        package = xml.etree.ElementTree.parse(DRIVER / "package.xml").getroot()
        sources = list((DRIVER / "src").iterdir())
        included = {name for source in sources for name in re.findall(r"#include <(\w+)/[\w/]+\.hp?p?>", source.read_text())} - {"stof"}
        included.add("std_msgs")  # by the messages
        self.assertEqual(included, {depend.text for depend in package.findall("depend")})
        for name in included:
            self.assertRegex(rules, rf"\b{name}\b")
        for source in sources:
            self.assertTrue(source.suffix == ".h" or f"src/{source.name}" in rules, source)

    def test_the_drivers_launch_file_sets_parameters_that_the_component_has(self):
        text = (DRIVER / "launch/driver.launch.py").read_text()
        compile(ast.parse(text), "driver.launch.py", "exec")
        node = (DRIVER / "src/sensor_node.cpp").read_text()
        declared = set(re.findall(r'declare_parameter<[\w:]+>\("(\w+)"', node))
        told = set(re.findall(r'"(\w+)": ParameterValue', text))
        self.assertTrue(told and told <= declared, told)
        arguments = set(re.findall(r'DeclareLaunchArgument\("(\w+)"', text))
        self.assertEqual(arguments, set(re.findall(r'LaunchConfiguration\("(\w+)"\)', text)))
        plugin = re.search(r'plugin="([\w:]+)"', text)[1]
        self.assertIn(f"RCLCPP_COMPONENTS_REGISTER_NODE({plugin})", node)
        self.assertIn(f'PLUGIN "{plugin}"', (DRIVER / "CMakeLists.txt").read_text())

    def test_the_driver_publishes_what_the_bridge_does(self):
        node = (DRIVER / "src/sensor_node.cpp").read_text()
        table = (ROOT / "host/bridge/topics.h").read_text()
        names = re.findall(r'create_publisher<[\w:]+>\(\s*"([\w/]+)"', node)
        self.assertEqual(len(names), 4)
        for name in names:
            self.assertIn(f'{{"{name}", ', table)
        for suffix in ("_link", "_left_optical_frame"):
            self.assertIn(f'prefix_ + "{suffix}"', node)
            self.assertIn(f'prefix + "{suffix}"', (ROOT / "host/bridge/topics.cpp").read_text())

    def test_urdf_mounts_the_bridges_link(self):
        macro = xml.etree.ElementTree.parse(PACKAGE / "urdf/stof.urdf.xacro").getroot().find(f"{XACRO}macro")
        self.assertEqual(macro.get("params").split(), ["name", "parent", "*origin"])
        self.assertEqual([link.get("name") for link in macro.iter("link")], ["${name}_link"])
        self.assertEqual((macro.find("joint/parent").get("link"), macro.find("joint/child").get("link")), ("${parent}", "${name}_link"))
        self.assertIn('prefix + "_link"', (ROOT / "host/bridge/topics.cpp").read_text())

    def test_launch_file_starts_the_bridge_with_flags_that_it_has(self):
        text = (PACKAGE / "launch/stof.launch.py").read_text()
        tree = ast.parse(text)
        compile(tree, "stof.launch.py", "exec")
        self.assertIn("generate_launch_description", [node.name for node in tree.body if isinstance(node, ast.FunctionDef)])
        flags = re.findall(r'"(--[\w-]+)"', text)
        self.assertGreater(len(flags), 3)
        known = (ROOT / "host/cli/bridge/bridge.cpp").read_text()
        for flag in flags:
            self.assertIn(f'"{flag}"', known)
        declared = re.findall(r'DeclareLaunchArgument\("(\w+)"', text)
        used = ast.literal_eval(re.search(r"for name in (\(.*?\))", text)[1])
        self.assertEqual(sorted(declared), sorted(used))

    def test_costmap_reads_the_bridges_cloud(self):
        text = (PACKAGE / "config/nav2_costmap.yaml").read_text()
        self.assertIn("topic: /front/depth/points\n", text)
        self.assertIn("sensor_frame: front_left_optical_frame\n", text)
        try:
            import yaml
        except ImportError:
            self.skipTest("python3-yaml is not installed")
        layer = yaml.safe_load(text)["local_costmap"]["local_costmap"]["ros__parameters"]["voxel_layer"]
        self.assertIn(layer["observation_sources"], layer)


if __name__ == "__main__":
    unittest.main()
