"""One sensor: ros2 launch stof_description stof.launch.py sensor:=192.168.1.20 namespace:=front mount:=base_link:0.20,0,0.35"""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, ExecuteProcess, OpaqueFunction
from launch.substitutions import LaunchConfiguration


def bridge(context):
    """The bridge's process; a mount that is not told is the URDF's."""
    value = {name: LaunchConfiguration(name).perform(context) for name in ("sensor", "namespace", "mount", "cloud_step", "fragment", "datagram")}
    command = ["stof", "bridge", "ros2", value["sensor"], "--namespace", value["namespace"], "--cloud-step", value["cloud_step"],
               "--fragment", value["fragment"], "--datagram", value["datagram"]]
    if value["mount"]:
        command += ["--mount", value["mount"]]
    return [ExecuteProcess(cmd=command, output="screen", respawn=True, respawn_delay=1.0)]


def generate_launch_description():
    return LaunchDescription([
        DeclareLaunchArgument("sensor", description="HOST[:PORT] of the sensor"),
        DeclareLaunchArgument("namespace", default_value="stof", description="of its topics and frames"),
        DeclareLaunchArgument("mount", default_value="", description="PARENT:X,Y,Z[,ROLL,PITCH,YAW]; empty: the robot's URDF has it"),
        DeclareLaunchArgument("cloud_step", default_value="4", description="pixels that a point of the cloud is of"),
        DeclareLaunchArgument("fragment", default_value="1344", description="bytes; 60000 where all nodes are on this computer"),
        DeclareLaunchArgument("datagram", default_value="14720", description="bytes; 1400 where the network loses more than one packet of a thousand"),
        OpaqueFunction(function=bridge),
    ])
