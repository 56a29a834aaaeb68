"""Hashes of types, which decide whether a peer of ROS 2 understands us, and the definitions that they are made from."""

from __future__ import annotations

from pathlib import Path

import pytest

from engine.errors import UsageError
from engine.ros.interfaces.definitions import Definitions, UnknownType

JAZZY = {
    "std_msgs/msg/String": "df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18",
    "std_msgs/msg/Header": "f49fb3ae2cf070f793645ff749683ac6b06203e41c891e17701b1cb597ce6a01",
    "std_msgs/msg/Empty": "20b625256f32d5dbc0d04fee44f43c41e51c70d3502f84b4a08e7a9c26a96312",
    "std_msgs/msg/Char": "3ad2d04dd29ba19d04b16659afa3ccaedd691914b02a64e82e252f2fa6a586a9",
    "std_msgs/msg/Byte": "41e1a3345f73fe93ede006da826a6ee274af23dd4653976ff249b0f44e3e798f",
    "std_msgs/msg/Float64MultiArray": "1025ddc6b9552d191f89ef1a8d2f60f3d373e28b283d8891ddcc974e8c55397f",
    "builtin_interfaces/msg/Time": "b106235e25a4c5ed35098aa0a61a3ee9c9b18d197f398b0e4206cea9acf9c197",
    "geometry_msgs/msg/Twist": "9c45bf16fe0983d80e3cfe750d6835843d265a9a6c46bd2e609fcddde6fb8d2a",
    "geometry_msgs/msg/TwistStamped": "5f0fcd4f81d5d06ad9b4c4c63e3ea51b82d6ae4d0558f1d475229b1121db6f64",
    "geometry_msgs/msg/PoseWithCovarianceStamped": "26432f9803e43727d3c8f668d1fdb3c630f548af631e2f4e31382371bfea3b6e",
    "geometry_msgs/msg/TransformStamped": "0a241f87d04668d94099cbb5ba11691d5ad32c2f29682e4eb5653424bd275206",
    "nav_msgs/msg/Odometry": "3cc97dc7fb7502f8714462c526d369e35b603cfc34d946e3f2eda2766dfec6e0",
    "nav_msgs/msg/OccupancyGrid": "8d348150c12913a31ee0ec170fbf25089e4745d17035792a1ba94d6f0bc0cfc7",
    "nav_msgs/msg/Path": "1957a5bb3cee5da65c4e52e52b65a93df227efce4c20f8458b36e73066ca334b",
    "sensor_msgs/msg/LaserScan": "64c191398013af96509d518dac71d5164f9382553fce5c1f8cca5be7924bd828",
    "sensor_msgs/msg/Image": "d31d41a9a4c4bc8eae9be757b0beed306564f7526c88ea6a4588fb9582527d47",
    "sensor_msgs/msg/CompressedImage": "15640771531571185e2efc8a100baf923961a4d15d5569652e6cb6691e8e371a",
    "sensor_msgs/msg/CameraInfo": "b3dfd68ff46c9d56c80fd3bd4ed22c7a4ddce8c8348f2f59c299e73118e7e275",
    "sensor_msgs/msg/BatteryState": "4bee5dfce981c98faa6828b868307a0a73f992ed0789f374ee96c8f840e69741",
    "sensor_msgs/msg/JointState": "a13ee3a330e346c9d87b5aa18d24e11690752bd33a0350f11c5882bc9179260e",
    "sensor_msgs/msg/PointCloud2": "9198cabf7da3796ae6fe19c4cb3bdd3525492988c70522628af5daa124bae2b5",
    "trajectory_msgs/msg/JointTrajectory": "179b33eba59d676f6d967ac71fe35e7ca2f64b2f3928f4a018cec115e213796e",
    "service_msgs/msg/ServiceEventInfo": "41bcbbe07a75c9b52bc96bfd5c24d7f0fc0a08c0cb7921b3373c5732345a6f45",
    "unique_identifier_msgs/msg/UUID": "1b8e8aca958cbea28fe6ef60bf6c19b683c97a9ef60bb34752067d0f2f7ab437",
    "action_msgs/msg/GoalStatusArray": "6c1684b00f177d37438febe6e709fc4e2b0d4248dca4854946f9ed8b30cda83e",
    "std_srvs/srv/Trigger": "eeff2cd6fa5ad9d27cdf4dec64818317839b62f212a91e6b5304b634b2062c5f",
    "std_srvs/srv/SetBool": "abe9e4bb6b41b40e6789712c00ec8871923e089af3f667a79992a428cff2da0a",
    "std_srvs/srv/Empty": "5888399dedec5ccc85ea6451949fd2c9f97bfdf963f9a588821639fcd31b5d19",
    "std_srvs/srv/Trigger_Request": "d010825374ce8918e72bfd826c82603e60f45419e932ea976f807b74a863a199",
    "std_srvs/srv/Trigger_Event": "ec4a1d26b0575e61906890342aba9523a2360e9845857c5590fa6e23bc39e1c2",
    "action_msgs/srv/CancelGoal": "573d8b0a534451d7bc2ac8c5ffde8ac14b8593b7001175d0cd6516dcbeb8689a",
    "example_interfaces/srv/AddTwoInts": "e118de6bf5eeb66a2491b5bda11202e7b68f198d6f67922cf30364858239c81a",
    "test_msgs/action/Fibonacci": "be9273e3557225044b4a040811112491f7079326e3a573f83258b0b4c30bd069",
    "test_msgs/action/Fibonacci_Goal": "e58ef5a8f4f039ab522a740823547c460b1d5aed8031c8b7825d33d345d90df8",
    "test_msgs/action/Fibonacci_SendGoal": "d807633803e38e164276573cd97e9fbd71e109c290bbf4cc312a0a1c9da7bbd9",
    "test_msgs/action/Fibonacci_SendGoal_Response": "1e7e84f7edf1fb020d9e51c7842bceef4cbdbd847f354125f3227cf4f314a683",
    "test_msgs/action/Fibonacci_GetResult": "5d30fdeb21d20e117aa5f36c7b4f0b6874f1a8cf7a9c038d58f1156c5737b209",
    "test_msgs/action/Fibonacci_GetResult_Event": "fe0aa5843ef10550a9b322aeeccd5b11e78bca05b3571cf6999c51bff30c1e23",
    "test_msgs/action/Fibonacci_FeedbackMessage": "37487bae8cea358366b97003c1ef1ca7ce7c08df36f9e8cca496624226aee64e",
}
"""As the packages of ROS 2 Jazzy carry them; that of AddTwoInts is from the documents of rmw_zenoh."""

GREETINGS = ('"Hello world!"', '"Hello\'world!"', "'Hello\"world!'", "'Hello\\'world!'", '"Hello\\"world!"')


@pytest.fixture(scope="module")
def known() -> Definitions:
    return Definitions()


@pytest.mark.parametrize("type", JAZZY)
def test_a_type_has_the_hash_that_jazzy_gives_it(known: Definitions, type: str) -> None:
    assert known.hash(type) == f"RIHS01_{JAZZY[type]}"


@pytest.mark.parametrize(
    "type",
    [
        "nav2_msgs/action/NavigateToPose",
        "control_msgs/action/FollowJointTrajectory",
        "control_msgs/action/GripperCommand",
        "example_interfaces/action/Fibonacci",
        "sayso_interfaces/srv/GetPlan",
        "sayso_interfaces/action/ExecutePlan",
    ],
)
def test_an_interface_of_ours_is_complete(known: Definitions, type: str) -> None:
    parts = ("", "_SendGoal", "_GetResult", "_FeedbackMessage") if "/action/" in type else ("", "_Request", "_Response")
    assert len({known.hash(f"{type}{part}") for part in parts}) == len(parts)


def test_bounds_count_and_defaults_do_not(tmp_path: Path) -> None:
    """As test_msgs/msg/Strings of Jazzy has it."""
    values = ("", *(f"_default{n} {text}" for n, text in enumerate(GREETINGS, 1)))
    plain = "".join(f"string string_value{value}\n" for value in values)
    bounded = "".join(f"string<=22 bounded_string_value{value}\n" for value in values)
    define(tmp_path, "test_msgs/msg/Strings.msg", f'{plain}string STRING_CONST="Hello world!"\n{bounded}')
    hash = "RIHS01_eee55533636293ac7c94c62432eedb5777eb849847d2a17b4dcead8c4a20ab32"
    assert Definitions([tmp_path]).hash("test_msgs/msg/Strings") == hash


def test_types_in_a_folder_of_the_users_are_found_however_deep(tmp_path: Path) -> None:
    define(tmp_path, "src/stack/my_msgs/msg/Point.msg", "int32 x\nint32 y 7  # metres\n")
    define(tmp_path, "src/stack/my_msgs/srv/Where.srv", "Point from\n---\nPoint[<=2] to\ngeometry_msgs/Pose pose\n")
    known = Definitions([tmp_path])
    request, response = (known.fields(f"my_msgs/srv/Where_{part}") for part in ("Request", "Response"))
    assert [(field.name, field.nested) for field in request] == [("from", "my_msgs/msg/Point")]
    assert [(field.type_id, field.capacity) for field in response] == [(97, 2), (1, 0)]
    assert known.default("my_msgs/msg/Point", "y") == 7


def test_what_the_user_defines_wins_over_what_is_known(tmp_path: Path) -> None:
    define(tmp_path, "std_srvs/srv/Trigger.srv", "---\nbool success\nstring message\nint32 code\n")
    define(tmp_path, "std_msgs/msg/String.msg", "string data\nstring language\n")
    known = Definitions([tmp_path])
    assert known.hash("std_srvs/srv/Trigger") != f"RIHS01_{JAZZY['std_srvs/srv/Trigger']}"
    assert [field.name for field in known.fields("std_msgs/msg/String")] == ["data", "language"]


@pytest.mark.parametrize(
    "type", ["foo_msgs/msg/Bar", "std_srvs/srv/Nothing", "std_msgs/String", "nonsense", "", "a/msg/"]
)
def test_a_type_that_nobody_has_defined_says_how_to_define_it(known: Definitions, type: str) -> None:
    with pytest.raises(UnknownType, match=r"\.msg, \.srv or \.action"):
        known.hash(type)


@pytest.mark.parametrize("text", ["int32\n", "wstring s\n", "int32 x\n---\nint32 y\n", "Unheard of\n", "\x00"])
def test_a_file_that_cannot_be_read_is_named(tmp_path: Path, text: str) -> None:
    define(tmp_path, "odd_msgs/msg/Odd.msg", text)
    with pytest.raises(UsageError, match="odd_msgs"):
        Definitions([tmp_path]).hash("odd_msgs/msg/Odd")


def define(folder: Path, name: str, text: str) -> None:
    path = folder / name
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)
