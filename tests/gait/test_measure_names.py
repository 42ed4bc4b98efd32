"""Names and patterns of measures that a study may ask for."""

from warpmuscle.gait.measure_names import can_be_measured


def test_patterns_fit_what_they_could_be_of():
    assert all(map(can_be_measured, ("knee*", "work of left brace", "positive*", "*power*", "step lengt?")))
    assert not any(map(can_be_measured, ("knees*", "work off*", "elbow*", "", "step lenght")))
    assert can_be_measured("co2", ["co2"])
