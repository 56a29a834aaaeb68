"""Other names for rooms and furniture: understood where a house has one of them, never against its own names."""

from __future__ import annotations

import pytest

from config.schema import Place, Position
from engine.skills.places import Places, UnknownPlace
from engine.skills.synonyms import synonyms


def house(*names: str) -> Places:
    return Places({f"P{at}": Place(name=name, position=Position(x=at, y=0)) for at, name in enumerate(names)})


@pytest.mark.parametrize(
    ("name", "said"), [("sofa", "settee"), ("couch", "the sofa"), ("counter", "worktop"), ("沙发", "couch")]
)
def test_a_place_has_the_other_names_of_its_kind(name: str, said: str) -> None:
    assert house("hall", name).symbol(said) == "P1"


def test_a_name_of_the_house_means_what_is_called_so_there() -> None:
    assert house("study", "office").symbol("office") == "P1"
    assert house("study").symbol("office") == "P0"


def test_a_word_that_could_mean_two_places_means_none() -> None:
    with pytest.raises(UnknownPlace):
        house("study", "office").symbol("workroom")


def test_other_names_are_no_names_to_be_listed() -> None:
    assert house("sofa").names() == ("sofa",)
    assert house("sofa").words("P0") == ("sofa",)


def test_what_is_taken_is_left_out() -> None:
    assert "couch" in synonyms({"sofa": "sofa"})
    assert "couch" not in synonyms({"sofa": "sofa"}, ["couch"])
