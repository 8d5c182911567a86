// SPDX-License-Identifier: BSD-3-Clause
#include "moving_things.hpp"

#include "bind_config.hpp"
#include "point_lists.hpp"
#include "voxnav/occupancy/moving_things.hpp"

namespace voxnav::bindings {
namespace {

using occupancy::LocalMap;
using occupancy::MovingThing;
using occupancy::MovingThings;
using occupancy::MovingThingsConfig;

void bind_thing(py::module_& m) {
  py::class_<MovingThing>(m, "MovingThing", "Something that moves, as it is at the stamp of the newest sweep.")
      .def_readonly("id", &MovingThing::id, "The same as long as it is followed.")
      .def_property_readonly(
          "position", [](const MovingThing& t) { return vec3_array(t.position); }, "(3,) middle of its box [m].")
      .def_property_readonly(
          "velocity", [](const MovingThing& t) { return vec3_array(t.velocity); }, "(3,) [m/s].")
      .def_property_readonly(
          "half_size_m", [](const MovingThing& t) { return vec3_array(t.half_size_m); },
          "(3,) half the size of the box around all that was seen of it [m].")
      .def_readonly("position_sigma_m", &MovingThing::position_sigma_m)
      .def_readonly("velocity_sigma_mps", &MovingThing::velocity_sigma_mps);
}

}  // namespace

void bind_moving_things(py::module_& m) {
  bind_config<MovingThingsConfig>(m, "MovingThingsConfig", "Parameters of MovingThings.");
  bind_thing(m);
  py::class_<MovingThings>(m, "MovingThings",
                           "Finds and follows what moves in a LocalMap, and takes what it left out of the map.")
      .def(py::init<const MovingThingsConfig&>(), py::arg("config") = MovingThingsConfig{})
      .def(
          "update",
          [](MovingThings& things, LocalMap& map, double stamp_s, const py::object& position_W) {
            things.update(&map, base::from_seconds(stamp_s), vec3_of(position_W, "position_W"));
          },
          py::arg("map"), py::arg("stamp_s"), py::arg("position_W"),
          "Takes the hits of the scan that was just inserted into the map; position_W: (3,) of the vehicle [m].")
      .def_property_readonly("things", &MovingThings::things, "List of MovingThing, by rising id.")
      .def_property_readonly("num_not_followed", &MovingThings::num_not_followed,
                             "Clusters of hits that were not followed because there were too many.")
      .def("clear", &MovingThings::clear, "Forgets everything that is followed.");
}

}  // namespace voxnav::bindings
