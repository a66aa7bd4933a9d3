#!/usr/bin/env python3
"""What ros2/ holds, without ROS: XML, Python and YAML are read, and names are those of the bridge."""

import ast
import pathlib
import re
import unittest
import xml.etree.ElementTree

ROOT = pathlib.Path(__file__).resolve().parents[2]
PACKAGE = ROOT / "ros2/stof_description"
XACRO = "{http://www.ros.org/wiki/xacro}"


class Ros2Folder(unittest.TestCase):
    def test_package_has_the_version_and_name_of_the_project(self):
        package = xml.etree.ElementTree.parse(PACKAGE / "package.xml").getroot()
        self.assertEqual(package.findtext("name"), PACKAGE.name)
        version = re.search(r"project\(stof VERSION (\S+)", (ROOT / "CMakeLists.txt").read_text())[1]
        self.assertEqual(package.findtext("version"), version)
        self.assertTrue((PACKAGE / package.find("license").get("file")).resolve().is_file())
        installed = re.search(r"install\(DIRECTORY ([\w ]+) DESTINATION", (PACKAGE / "CMakeLists.txt").read_text())[1].split()
        self.assertEqual(sorted(installed), sorted(path.name for path in PACKAGE.iterdir() if path.is_dir()))

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
