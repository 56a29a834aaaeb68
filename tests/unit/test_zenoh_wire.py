"""How a ROS 2 graph is written into zenoh, byte for byte as rmw_zenoh_cpp does."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from engine.ros.door import Graph
from engine.ros.zenoh.graph import Tokens, graph_of, mismatch
from engine.ros.zenoh.wire import (
    LATCHED,
    Attachment,
    Endpoint,
    Entity,
    Kind,
    Qos,
    dds_type,
    gid,
    ros_name,
    ros_type,
    tokens,
)
from engine.ros.zenoh.xxh3 import xxh3_128

STRING = "RIHS01_df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18"
SUM = "RIHS01_e118de6bf5eeb66a2491b5bda11202e7b68f198d6f67922cf30364858239c81a"
CHATTER = Endpoint("/chatter", "std_msgs/msg/String", STRING)
ADD = Endpoint("/add_two_ints", "example_interfaces/srv/AddTwoInts", SUM)

# From docs/design.md of rmw_zenoh
LISTENER_NODE = "@ros2_lv/0/aac3178e146ba6f1fc6e6a4085e77f21/0/0/NN/%/%/listener"
LISTENER = (
    "@ros2_lv/0/aac3178e146ba6f1fc6e6a4085e77f21/0/10/MS/%/%/listener/%chatter/"
    f"std_msgs::msg::dds_::String_/{STRING}/::,10:,:,:,,"
)
TALKER = (
    "@ros2_lv/0/8b20917502ee955ac4476e0266340d5c/0/10/MP/%/%/talker/%chatter/"
    f"std_msgs::msg::dds_::String_/{STRING}/::,7:,:,:,,"
)
SERVER = (
    "@ros2_lv/0/f9980ee0495eaafb3e38f0d19e2eae12/0/10/SS/%/%/add_two_ints_server/%add_two_ints/"
    f"example_interfaces::srv::dds_::AddTwoInts_/{SUM}/::,10:,:,:,,"
)
CLIENT = SERVER.replace("SS/%/%/add_two_ints_server", "SC/%/%/add_two_ints_client")


def entity(kind: Kind, node: str, endpoint: Endpoint | None, session: str = "a1") -> Entity:
    return Entity(0, session, 0, 10 if endpoint else 0, kind, node, endpoint)


@pytest.mark.parametrize(
    ("token", "entity"),
    [
        (LISTENER_NODE, Entity(0, "aac3178e146ba6f1fc6e6a4085e77f21", 0, 0, "NN", "listener")),
        (LISTENER, Entity(0, "aac3178e146ba6f1fc6e6a4085e77f21", 0, 10, "MS", "listener", CHATTER)),
        (TALKER, Entity(0, "8b20917502ee955ac4476e0266340d5c", 0, 10, "MP", "talker", CHATTER, Qos(7))),
        (SERVER, Entity(0, "f9980ee0495eaafb3e38f0d19e2eae12", 0, 10, "SS", "add_two_ints_server", ADD)),
        (CLIENT, Entity(0, "f9980ee0495eaafb3e38f0d19e2eae12", 0, 10, "SC", "add_two_ints_client", ADD)),
    ],
)
def test_a_token_says_what_it_is_about(token: str, entity: Entity) -> None:
    assert entity.token() == token
    assert Entity.parse(token) == entity


def test_the_keys_of_messages_keep_the_slashes_of_names() -> None:
    assert CHATTER.key(0) == f"0/chatter/std_msgs::msg::dds_::String_/{STRING}"
    assert Endpoint("/robot1/chatter", "std_msgs/msg/String", STRING).key(7).startswith("7/robot1/chatter/std_msgs::")
    assert ADD.key(2) == f"2/add_two_ints/example_interfaces::srv::dds_::AddTwoInts_/{SUM}"
    assert tokens(3) == "@ros2_lv/3/**"


@pytest.mark.parametrize(
    ("qos", "text"),
    [
        (Qos(), "::,10:,:,:,,"),
        (Qos(42), "::,:,:,:,,"),
        (LATCHED, ":1:,1:,:,:,,"),
        (Qos(5, reliable=False), "2::,5:,:,:,,"),
    ],
)
def test_quality_of_service_leaves_out_what_is_usual(qos: Qos, text: str) -> None:
    assert str(qos) == text
    assert Qos.parse(text) == qos


def test_what_a_later_release_adds_to_a_token_does_no_harm() -> None:
    found = Entity.parse(f"{TALKER}/backends:cpu:1")
    assert found is not None
    assert found.endpoint == CHATTER


@given(st.text(alphabet="@ros2_lv/0%ab:MPSN,", max_size=120) | st.text(max_size=60))
def test_a_token_that_makes_no_sense_is_none(text: str) -> None:
    found = Entity.parse(text)
    assert found is None or found.endpoint is None


NAMES = st.lists(st.from_regex(r"[A-Za-z_][A-Za-z0-9_]{0,8}", fullmatch=True), min_size=1, max_size=4).map(
    lambda parts: "/" + "/".join(parts)
)
ENDPOINTS = st.builds(
    Endpoint,
    NAMES,
    st.builds(
        "{}_msgs/{}/{}".format, st.sampled_from(("a", "b1")), st.sampled_from(("msg", "srv", "action")), st.just("Xy")
    ),
    st.just(STRING),
)
ENTITIES = st.builds(
    Entity,
    st.integers(0, 232),
    st.from_regex(r"[0-9a-f]{1,32}", fullmatch=True),
    st.integers(0, 99),
    st.integers(0, 99999),
    st.sampled_from(("MP", "MS", "SS", "SC")),
    st.just("node"),
    ENDPOINTS,
    st.builds(Qos, st.integers(1, 1000), st.booleans(), st.booleans()),
    NAMES | st.just("/"),
)


@given(ENTITIES)
def test_every_token_can_be_read_again(entity: Entity) -> None:
    assert Entity.parse(entity.token()) == entity


def test_an_attachment_is_as_the_serializer_of_zenoh_writes_it() -> None:
    ext = pytest.importorskip("zenoh.ext")
    id = bytes(range(16))
    ours = Attachment(7, 1_700_000_000_123_456_789, id)
    theirs = ext.z_serialize((ext.Int64(ours.number), ext.Int64(ours.stamp), id)).to_bytes()
    assert ours.pack() == theirs
    assert ours.pack().hex() == "070000000000000015cd853dfe9c971710000102030405060708090a0b0c0d0e0f"
    assert Attachment.parse(theirs) == ours


@given(st.binary(max_size=60).filter(lambda data: len(data) != 33 or data[16] != 16))
def test_another_attachment_is_an_error(data: bytes) -> None:
    with pytest.raises(ValueError, match="attachment"):
        Attachment.parse(data)


@pytest.mark.parametrize(
    ("text", "hash"),
    [
        (TALKER, 0x62D00A8901458A44DC46783B88FA85EB),
        (
            TALKER.replace("%chatter", "%a_long_namespace%of_a_robot%chatter_chatter_chatter" * 2),
            0xF1D7972A29E4952E4EE62273B94857F6,
        ),
        ("a" * 129, 0xA7758BDD09A0B20FD53A57A017F40A2F),
        ("b" * 1200, 0x80CEE40EC837FA5DF45B6262B8CDA928),
    ],
)
def test_ids_are_made_by_xxh3_of_128_bits(text: str, hash: int) -> None:
    """Expected values by the reference implementation."""
    low, high = xxh3_128(text.encode())
    assert high << 64 | low == hash
    assert gid(text) == hash.to_bytes(16, "little")


def test_a_text_too_short_to_be_a_token_has_no_id() -> None:
    with pytest.raises(ValueError, match="129"):
        gid("short")


@pytest.mark.parametrize(
    ("ros", "dds"),
    [("std_msgs/msg/String", "std_msgs::msg::dds_::String_"), ("t/action/F_SendGoal", "t::action::dds_::F_SendGoal_")],
)
def test_types_are_named_as_in_dds(ros: str, dds: str) -> None:
    assert dds_type(ros) == dds
    assert ros_type(dds) == ros


@pytest.mark.parametrize("name", ["", "/", "a//b", "/a/", "a b", "/a/*", "/a/**", "/a?b", "/a#b", "/1a", "/a$*", "@x"])
def test_a_name_that_ros_does_not_allow_reaches_no_key(name: str) -> None:
    with pytest.raises(ValueError, match="no name"):
        ros_name(name)


def test_the_graph_hides_what_actions_are_made_of() -> None:
    send = Endpoint("/fib/_action/send_goal", "test_msgs/action/Fibonacci_SendGoal", SUM)
    feedback = Endpoint("/fib/_action/feedback", "test_msgs/action/Fibonacci_FeedbackMessage", SUM)
    wanted = Endpoint("/wanted", "std_msgs/msg/String", STRING)
    heard = [
        entity("NN", "robot", None),
        entity("MP", "robot", CHATTER),
        entity("SS", "robot", ADD),
        entity("SS", "robot", send),
        entity("MP", "robot", feedback),
        entity("MS", "robot", Endpoint("/cmd_vel", "std_msgs/msg/String", STRING)),
        entity("MS", "sayso", wanted, session="ours"),
        entity("SC", "sayso", Endpoint("/looked_for", "std_msgs/msg/String", STRING), session="ours"),
    ]
    assert graph_of(heard, "ours") == Graph(
        {"/chatter": "std_msgs/msg/String", "/cmd_vel": "std_msgs/msg/String"},
        {"/add_two_ints": "example_interfaces/srv/AddTwoInts"},
        {"/fib": "test_msgs/action/Fibonacci"},
    )


def test_a_peer_with_another_type_is_told_of() -> None:
    ours = entity("MS", "sayso", CHATTER)
    other_type = entity("MP", "robot", Endpoint("/chatter", "std_msgs/msg/Int32", SUM))
    other_fields = entity("MP", "robot", Endpoint("/chatter", "std_msgs/msg/String", SUM))
    assert mismatch(ours, entity("MP", "robot", CHATTER)) == ""
    assert mismatch(ours, other_type) == "robot publishes it as std_msgs/msg/Int32, and here it is std_msgs/msg/String"
    assert "other fields" in mismatch(ours, other_fields)
    heard = Tokens()
    heard.add(other_fields.token())
    assert "other fields" in heard.mismatches([ours])["/chatter"]
    heard.remove(other_fields.token())
    assert heard.mismatches([ours]) == {}
