"""One sensor: ros2 launch stof_driver driver.launch.py sensor:=192.168.1.20 namespace:=front"""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import ComposableNodeContainer
from launch_ros.descriptions import ComposableNode
from launch_ros.parameter_descriptions import ParameterValue


def generate_launch_description():
    """A container with the sensor; other components are loaded beside it, and get its messages without a copy."""
    node = ComposableNode(
        package="stof_driver", plugin="stof_driver::SensorNode", name="stof", namespace=LaunchConfiguration("namespace"),
        parameters=[{"sensor": ParameterValue(LaunchConfiguration("sensor"), value_type=str),
                     "cloud_step": ParameterValue(LaunchConfiguration("cloud_step"), value_type=int)}],
        extra_arguments=[{"use_intra_process_comms": True}])
    return LaunchDescription([
        DeclareLaunchArgument("sensor", description="HOST[:PORT] of the sensor"),
        DeclareLaunchArgument("namespace", default_value="stof", description="of its topics; with _ for / of its frames"),
        DeclareLaunchArgument("cloud_step", default_value="4", description="pixels that a point of the cloud is of; 0: no cloud"),
        ComposableNodeContainer(package="rclcpp_components", executable="component_container", name="stof_container",
                                namespace=LaunchConfiguration("namespace"), composable_node_descriptions=[node], output="screen"),
    ])
