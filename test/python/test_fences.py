# SPDX-License-Identifier: BSD-3-Clause
"""Fences are read from world configurations and files, placed by transforms, and refused with a reason."""

import numpy as np
import pyproj
import pytest
import yaml

import voxnav
from voxnav.fences import (FenceBook, FenceError, FencePrism, Limits, place, read_prism, read_world_config,
                           virtual_obstacle)
from voxnav.fences.utm import utm_of, zone_of

WORLD = """
world_origin:
  units: "LATLON" # {"UTM, "LATLON"}
  origin_x: 47.397743
  origin_y: 8.545594
safety_area:
  enabled: true
  horizontal:
    frame_name: "world_origin"
    points: [
      -50, -50,
      50,  -50,
      50,  50,
      -50, 50,
    ]
  vertical:
    frame_name: "world_origin"
    max_z: 15.0
    min_z: 0.5
"""
SQUARE = [[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]]


def square(name="a", frame="uav1/world_origin", **kwargs):
    values = dict(points=np.array(SQUARE), vertical_frame=frame, min_z=0.0, max_z=3.0)
    values.update(kwargs)
    return FencePrism(name, frame, **values)


def changed(**changes):
    """Returns the text of WORLD with values replaced, whose keys are paths with __ for /; None removes one."""
    tree = yaml.safe_load(WORLD)
    for path, value in changes.items():
        *sections, key = path.split("__")
        section = tree
        for name in sections:
            section = section[name]
        if value is None:
            del section[key]
        else:
            section[key] = value
    return yaml.safe_dump(tree)


def pose(x=0.0, y=0.0, z=0.0, yaw=0.0):
    T = np.eye(4)
    T[:2, :2] = [[np.cos(yaw), -np.sin(yaw)], [np.sin(yaw), np.cos(yaw)]]
    T[:3, 3] = (x, y, z)
    return T


def known(**frames):
    def lookup(frame):
        if frame.split("/")[-1] not in frames:
            raise FenceError("no transform from frame '%s'" % frame)
        return frames[frame.split("/")[-1]]
    return lookup


# UTM


@pytest.mark.parametrize("latitude, longitude", [
    (49.3625, 14.2600), (47.397743, 8.545594), (-33.86, 151.21), (0.0, 3.0), (-0.1, -179.99), (71.1, 25.7),
    (83.9, -30.1), (-79.9, 0.01), (50.0, 11.999), (50.0, 12.001)])
def test_utm_is_that_of_an_independent_library(latitude, longitude):
    zone, is_south = zone_of(longitude), latitude < 0.0
    theirs = pyproj.Proj(proj="utm", zone=zone, ellps="WGS84", south=is_south)(longitude, latitude)
    assert utm_of(latitude, longitude, zone, is_south) == pytest.approx(theirs, abs=1e-4)


def test_utm_in_a_neighbouring_zone_and_over_the_date_line():
    for latitude, longitude, zone in ((50.0, 12.5, 32), (50.0, 11.5, 33), (10.0, -179.5, 60), (10.0, 179.5, 1)):
        theirs = pyproj.Proj(proj="utm", zone=zone, ellps="WGS84")(longitude, latitude)
        assert utm_of(latitude, longitude, zone, False) == pytest.approx(theirs, abs=1e-3)


def test_utm_of_random_places_is_that_of_an_independent_library():
    rng = np.random.default_rng(1)
    for _ in range(300):
        latitude, longitude = rng.uniform(-80.0, 84.0), rng.uniform(-180.0, 180.0)
        theirs = pyproj.Proj(proj="utm", zone=zone_of(longitude), ellps="WGS84", south=bool(latitude < 0.0))
        ours = utm_of(latitude, longitude, zone_of(longitude), bool(latitude < 0.0))
        assert ours == pytest.approx(theirs(longitude, latitude), abs=1e-4)


@pytest.mark.parametrize("latitude, longitude", [(91.0, 0.0), (-85.0, 0.0), (0.0, 181.0), (np.nan, 0.0), (0.0, np.inf)])
def test_places_outside_utm_are_refused(latitude, longitude):
    with pytest.raises(ValueError, match="no place of UTM"):
        utm_of(latitude, longitude, 33, False)


# World configurations


def test_a_world_configuration_of_mrs_is_read():
    world = read_world_config(WORLD)
    assert world.area.points.tolist() == [[-50, -50], [50, -50], [50, 50], [-50, 50]]
    assert (world.area.frame, world.area.vertical_frame) == ("world_origin", "world_origin")
    assert (world.area.min_z, world.area.max_z) == (0.5, 15.0)
    assert world.origin.zone == 32 and not world.origin.is_south and world.holes == ()
    theirs = pyproj.Proj(proj="utm", zone=32, ellps="WGS84")(8.545594, 47.397743)
    assert (world.origin.east_m, world.origin.north_m) == pytest.approx(theirs, abs=1e-3)
    pairs = read_world_config(changed(safety_area__horizontal__points=SQUARE))
    assert pairs.area.points.tolist() == SQUARE
    utm = read_world_config(changed(world_origin__units="utm", world_origin__origin_x=465695.0,
                                    world_origin__origin_y=5249461.0))
    assert (utm.origin.east_m, utm.origin.north_m, utm.origin.zone) == (465695.0, 5249461.0, None)


def test_an_area_that_is_not_enabled_is_no_fence():
    assert read_world_config(changed(safety_area__enabled=False)).area is None
    # Whatever else is wrong with it does not matter then, as in MRS.
    assert read_world_config(changed(safety_area__enabled=False, safety_area__horizontal=None)).area is None


def test_holes_of_the_area_are_zones():
    hole = {"horizontal": {"frame_name": "world_origin", "points": [0, 0, 5, 0, 5, 5]},
            "vertical": {"frame_name": "world_origin", "min_z": 0, "max_z": 10}}
    world = read_world_config(changed(safety_area__obstacles={"present": True, "count": 1, "obstacle_0": hole}))
    assert [zone.name for zone in world.holes] == ["safety_area/obstacles/obstacle_0"]
    assert read_world_config(changed(safety_area__obstacles={"present": False, "obstacle_0": hole})).holes == ()
    with pytest.raises(FenceError, match="count is 2, but there are 1"):
        read_world_config(changed(safety_area__obstacles={"present": True, "count": 2, "obstacle_0": hole}))
    with pytest.raises(FenceError, match="obstacles/obstacle_0: section vertical is missing"):
        read_world_config(changed(safety_area__obstacles={"obstacle_0": {"horizontal": hole["horizontal"]}}))


@pytest.mark.parametrize("changes, message", [
    ({"safety_area": None}, "section safety_area is missing"),
    ({"safety_area": 3}, "section safety_area is missing"),
    ({"safety_area__enabled": None}, "safety_area/enabled must be true or false, and is missing"),
    ({"safety_area__enabled": "yes"}, "safety_area/enabled must be true or false, and is 'yes'"),
    ({"safety_area__horizontal": None}, "safety_area: section horizontal is missing"),
    ({"safety_area__vertical": 1}, "safety_area: vertical is no section"),
    ({"safety_area__horizontal__frame_name": None}, "horizontal/frame_name is missing"),
    ({"safety_area__horizontal__frame_name": 7}, "horizontal/frame_name is 7, not the name of a frame"),
    ({"safety_area__horizontal__points": None}, "horizontal/points is missing"),
    ({"safety_area__horizontal__points": 1.0}, "horizontal/points is no list"),
    ({"safety_area__horizontal__points": [1, 2, 3, 4, 5, "x"]}, "number 6 is 'x', not a finite number"),
    ({"safety_area__horizontal__points": [1, 2, 3, 4, 5, float("nan")]}, "number 6 is nan, not a finite number"),
    ({"safety_area__horizontal__points": [1, 2, 3, 4, 5]}, "5 numbers are no pairs"),
    ({"safety_area__horizontal__points": [[1, 2], [3, 4], [5]]}, "pairs of numbers"),
    ({"safety_area__horizontal__points": [1, 2, 3, 4]}, "at least 3 corners, and has 2"),
    ({"safety_area__horizontal__points": [0, 0, 2, 2, 2, 0, 0, 2]}, "cross or touch"),
    ({"safety_area__vertical__min_z": None}, "vertical/min_z is missing"),
    ({"safety_area__vertical__max_z": True}, "vertical/max_z is True, not a finite number"),
    ({"safety_area__vertical__max_z": 0.1}, "min_z must be below max_z"),
    ({"world_origin__units": "FEET"}, "world_origin/units must be UTM or LATLON, and is 'FEET'"),
    ({"world_origin__origin_x": None}, "world_origin/origin_x is missing"),
    ({"world_origin__origin_x": "a"}, "world_origin/origin_x is 'a', not a number"),
    ({"world_origin__origin_x": 95.0}, "world_origin: latitude 95"),
    ({"world_origin": 5}, "world_origin is no section"),
])
def test_malformed_world_configurations_are_refused_by_name(changes, message):
    with pytest.raises(FenceError) as error:
        read_world_config(changed(**changes))
    assert message in str(error.value)


def test_all_problems_are_listed_at_once():
    with pytest.raises(FenceError) as error:
        read_world_config(changed(world_origin__units="FEET", safety_area__horizontal__points=[1],
                                  safety_area__vertical__min_z=None))
    assert len(str(error.value).splitlines()) == 3


def test_files_are_named(tmp_path):
    book = FenceBook()
    with pytest.raises(FenceError, match="world configuration /nowhere/a.yaml cannot be read"):
        book.load_world("/nowhere/a.yaml")
    path = tmp_path / "world.yaml"
    for text in ("a: [1, 2", "\t", "- 1", ""):
        path.write_text(text)
        with pytest.raises(FenceError, match=str(path)):
            book.load_world(str(path))
    path.write_bytes(b"\xff\xfe\x00\x01")
    with pytest.raises(FenceError, match=str(path)):
        book.load_world(str(path))
    assert book.is_empty and book.version == 0
    path.write_text(WORLD)
    book.load_world(str(path))
    assert book.area is not None and book.version == 1


# Zones


def test_zones_are_replaced_removed_and_limited():
    book = FenceBook(Limits(max_zones=2, max_corners=5, max_zone_size_m=10.0))
    book.add(square("a"))
    book.add(square("a", max_z=5.0))
    book.add(square("b"))
    assert [zone.max_z for zone in book.zones] == [5.0, 3.0]
    for zone, message in ((square("c"), "3 zones are more than the 2"),
                          (square("a", points=np.array(SQUARE) * 3.0), "12 m are more than the 10 m"),
                          (square("a", max_z=11.0), "11 m are more than the 10 m"),
                          (square("a", points=np.array([[0, 0], [1, 0], [2, 1], [2, 2], [1, 2], [0, 1.0]])),
                           "6 corners are more than the 5"),
                          (square(""), "needs a name"), (square("a", min_z=9.0), "min_z must be below max_z"),
                          (square("a", points=np.zeros((0, 2))), "at least 3 corners, and has 0")):
        with pytest.raises(FenceError, match=message):
            book.add(zone)
    assert [zone.max_z for zone in book.zones] == [5.0, 3.0]
    with pytest.raises(FenceError, match="there is no zone 'x'; there are: a, b"):
        book.remove("x")
    book.remove("a")
    assert book.clear("other") == 0 and book.clear() == 1 and book.is_empty


def test_zones_survive_a_file(tmp_path):
    path = str(tmp_path / "zones.yaml")
    book, other = FenceBook(), FenceBook()
    book.add(square("mast", frame="latlon_origin", vertical_frame="amsl_origin",
                    points=np.array([[49.001, 14.2], [49.002, 14.2], [49.002, 14.201]])))
    book.add(square("house: 3", frame="local_origin"))
    assert book.save_zones(path) == 2
    assert other.load_zones(path) == 2
    assert [zone.to_tree() for zone in other.zones] == [zone.to_tree() for zone in book.zones]
    assert [zone.name for zone in other.zones] == ["mast", "house: 3"]
    with pytest.raises(FenceError, match="cannot be written"):
        book.save_zones("/nowhere/zones.yaml")


def test_a_file_of_zones_is_taken_as_a_whole_or_not(tmp_path):
    path = tmp_path / "zones.yaml"
    good, bad = square("good").to_tree(), square("bad").to_tree()
    bad["vertical"]["min_z"] = None
    path.write_text(yaml.safe_dump({"zones": {"good": good, "bad": bad, "worse": 3}}))
    book = FenceBook()
    with pytest.raises(FenceError) as error:
        book.load_zones(str(path))
    assert "bad: vertical/min_z is missing" in str(error.value) and "worse: section" in str(error.value)
    assert book.is_empty
    path.write_text("zones: [1]")
    with pytest.raises(FenceError, match="section zones is missing"):
        book.load_zones(str(path))


def test_a_virtual_obstacle_is_a_parallelogram():
    zone = virtual_obstacle("v", "uav1/world_origin", [(0, 0, 1), (4, 0, 1), (1, 3, 6)])
    assert zone.points.tolist() == [[0, 0], [4, 0], [5, 3], [1, 3]]
    assert (zone.min_z, zone.max_z) == (1.0, 6.0)
    for points, message in (([(0, 0, 1), (4, 0, 1)], "exactly 3 points"), ([(0, 0, 1), (4, 0, 1), (1, 3, 1)], "min_z"),
                            ([(0, 0, 1), (4, 0, 1), (8, 0, 2)], "cross or touch")):
        with pytest.raises(FenceError, match=message):
            virtual_obstacle("v", "f", points)


def test_a_prism_is_read_as_it_is_written():
    prism = square("a", frame="fcu_untilted", vertical_frame="amsl_origin")
    again = read_prism("a", prism.to_tree())
    assert again.to_tree() == prism.to_tree() and again.name == "a"


# Placing


def test_fences_are_placed_by_the_transforms_of_their_frames():
    book = FenceBook()
    book.add(square("a", vertical_frame="amsl_origin"))
    placed = place(book, known(world_origin=pose(10.0, 0.0, 1.0, yaw=np.pi / 2), amsl_origin=pose(z=-300.0)))
    zone = placed.fences.zones[0]
    assert zone.outline == pytest.approx(np.array([[10.0, 0.0], [10.0, 4.0], [6.0, 4.0], [6.0, 0.0]]))
    assert (zone.min_z, zone.max_z) == (-300.0, -297.0)
    assert placed.what(placed.fences.contact((8.0, 2.0, -299.0))) == "in the no-fly zone a"
    with pytest.raises(FenceError, match="a: no transform from frame 'uav1/world_origin'"):
        place(book, known(amsl_origin=pose()))


def test_latitude_and_longitude_need_only_the_world_frame(tmp_path):
    path = tmp_path / "world.yaml"
    degrees = [[47.3980, 8.5455], [47.3980, 8.5465], [47.3973, 8.5465], [47.3973, 8.5455]]
    path.write_text(changed(safety_area__horizontal__frame_name="latlon_origin",
                            safety_area__horizontal__points=degrees))
    book = FenceBook()
    book.load_world(str(path))
    placed = place(book, known(world_origin=pose(100.0, 200.0)))
    to_utm = pyproj.Proj(proj="utm", zone=32, ellps="WGS84")
    origin = np.array(to_utm(8.545594, 47.397743))
    expected = np.array([to_utm(longitude, latitude) for latitude, longitude in degrees]) - origin + (100.0, 200.0)
    assert placed.fences.area.outline == pytest.approx(expected, abs=1e-3)
    # Without an origin of the world frame, the frame of UTM itself is asked for.
    path.write_text(changed(safety_area__horizontal__frame_name="latlon_origin", world_origin=None,
                            safety_area__horizontal__points=degrees))
    book.load_world(str(path))
    placed = place(book, known(world_origin=pose(), utm_origin=pose(*-origin)))
    assert placed.fences.area.outline == pytest.approx(expected - (100.0, 200.0), abs=1e-3)


def test_coordinates_of_utm_are_those_of_the_world_frame(tmp_path):
    path = tmp_path / "world.yaml"
    path.write_text(changed(world_origin__units="UTM", world_origin__origin_x=465000.0,
                            world_origin__origin_y=5249000.0, safety_area__horizontal__frame_name="uav1/utm_origin",
                            safety_area__horizontal__points=[465000, 5249000, 465010, 5249000, 465010, 5249010]))
    book = FenceBook()
    book.load_world(str(path))
    placed = place(book, known(world_origin=pose()))
    assert placed.fences.area.outline == pytest.approx(np.array([[0.0, 0.0], [10.0, 0.0], [10.0, 10.0]]))


def test_fences_that_have_hardly_moved_are_the_same():
    book = FenceBook()
    book.add(square())
    at = [place(book, known(world_origin=pose(x=x))) for x in (0.0, 0.09, 0.11)]
    assert at[1].is_like(at[0]) and not at[2].is_like(at[0]) and not at[0].is_like(None)
    book.add(square("b"))
    assert not place(book, known(world_origin=pose())).is_like(at[0])
    assert place(FenceBook(), known()).fences.area is None


# Fences of the core


def test_fences_of_the_core_tell_what_a_place_violates():
    area = voxnav.Prism(np.array([[0.0, 0.0], [10.0, 0.0], [10.0, 10.0], [0.0, 10.0]]), 0.0, 5.0)
    fences = voxnav.Fences(area, [voxnav.Prism(np.array(SQUARE), 1.0, 2.0)])
    assert fences.contact((5.0, 5.0, 1.5)) is None
    assert fences.contact((11.0, 5.0, 1.5)).kind == voxnav.FenceKind.AREA
    zone = fences.contact((2.0, 2.0, 1.5))
    assert zone.kind == voxnav.FenceKind.ZONE and zone.zone == 0
    assert fences.first_touch((5.0, 5.0, 3.0), (15.0, 5.0, 3.0)).t == pytest.approx(0.5)
    assert fences.first_touch((5.0, 5.0, 3.0), (6.0, 5.0, 3.0), radius_m=0.5) is None
    assert voxnav.Prism(np.array(SQUARE), 1.0, 1.0).problem == "min_z must be below max_z"
    with pytest.raises(ValueError, match="zone 0: min_z"):
        voxnav.Fences(zones=[voxnav.Prism(np.array(SQUARE), 1.0, 1.0)])
    with pytest.raises(ValueError, match="outline must be"):
        voxnav.Prism(np.zeros((4, 3)), 0.0, 1.0)
