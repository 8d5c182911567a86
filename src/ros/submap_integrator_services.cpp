// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <sstream>

#include "submap_integrator_nodelet.hpp"
#include "voxnav/submap/submap_collection.hpp"
#include "voxnav_ros/submap_conversions.hpp"

namespace voxnav_ros {
namespace {

/// Answers a request with what `work` returns, or with the reason why it threw.
template <class Work>
bool answer(mrs_msgs::String::Response* response, Work&& work) {
  try {
    response->message = work();
    response->success = true;
  } catch (const std::exception& error) {
    response->message = error.what();
    response->success = false;
  }
  return true;
}

/// Reads "DIRECTORY" or "DIRECTORY x y z yaw", in metres and radians.
std::pair<std::string, voxnav::geometry::Pose> directory_and_pose(const std::string& text) {
  std::istringstream in(text);
  std::string directory;
  voxnav::geometry::Vec3 position = voxnav::geometry::Vec3::Zero();
  double yaw = 0.0;
  in >> directory;
  if (in >> position.x() && !(in >> position.y() >> position.z() >> yaw))
    throw std::invalid_argument("what to merge is given as: DIRECTORY [x y z yaw]");
  return {directory, voxnav::geometry::from_position_yaw(position, yaw)};
}

}  // namespace

bool SubmapIntegratorNodelet::on_get_obstacles(voxnav::GetGrid::Request&, voxnav::GetGrid::Response& response) {
  const std::lock_guard<std::mutex> lock(mutex_);
  response.success = true;
  // The answer has the sequence number of the last message, so that the next change follows it.
  response.grid = obstacle_msg(map_->obstacles().snapshot(), sequence_);
  return true;
}

bool SubmapIntegratorNodelet::on_get_submaps(voxnav::GetSubmaps::Request&, voxnav::GetSubmaps::Response& response) {
  const std::lock_guard<std::mutex> lock(mutex_);
  for (const submap::SubmapEntry* entry : map_->collection().entries()) {
    response.submaps.push_back(to_msg(*entry, origins_.frame()));
    express_now(*entry, &response.submaps.back());
  }
  response.success = true;
  return true;
}

/// Finished submaps never change, so only the list of them has to be copied while the mutex is held.
submap::SubmapCollection SubmapIntegratorNodelet::copy_of_map() {
  submap::SubmapCollection copy(collection_config_);
  const std::lock_guard<std::mutex> lock(mutex_);
  for (const submap::SubmapEntry* entry : map_->collection().entries()) copy.add(*entry);
  return copy;
}

std::size_t SubmapIntegratorNodelet::save(const std::string& directory) {
  const submap::SubmapCollection copy = copy_of_map();
  const std::lock_guard<std::mutex> lock(save_mutex_);
  copy.save(directory);
  return copy.size();
}

void SubmapIntegratorNodelet::autosave() {
  try {
    const auto timer = diagnostics().time("autosave");
    save(config_.autosave_dir);
  } catch (const std::exception& error) {
    refuse("autosave", error.what());
  }
}

bool SubmapIntegratorNodelet::on_save(mrs_msgs::String::Request& request, mrs_msgs::String::Response& response) {
  return answer(&response, [&] { return std::to_string(save(request.value)) + " submaps saved to " + request.value; });
}

/// Ensures that the next submap belongs to a newer flight than all loaded ones and gets an unused id.
void SubmapIntegratorNodelet::continue_from(const submap::SubmapCollection& loaded) {
  for (const submap::SubmapEntry* entry : loaded.entries()) {
    flight_ = std::max(flight_, entry->flight + 1);
    first_id_ = std::max(first_id_, entry->id + 1);
  }
  id_shift_.reset();
}

std::string SubmapIntegratorNodelet::show_loaded(std::size_t num_loaded, const std::vector<std::string>& problems) {
  enqueue("loaded map", [this] {
    refresh(last_stamp_);
    publish_obstacles(map_->obstacles().snapshot());
  });
  std::string out = std::to_string(num_loaded) + " submaps loaded";
  for (const std::string& problem : problems) out += "; left out: " + problem;
  return out;
}

/// Loads a map. Broken parts of the files are left out, and the answer tells which. Limits and page_dir stay those of
/// this node.
bool SubmapIntegratorNodelet::on_load(mrs_msgs::String::Request& request, mrs_msgs::String::Response& response) {
  return answer(&response, [&] {
    std::vector<std::string> problems;
    submap::SubmapCollection loaded = submap::SubmapCollection::load(request.value, &problems, &collection_config_);
    const std::lock_guard<std::mutex> lock(mutex_);
    continue_from(loaded);
    map_->replace(std::move(loaded));
    return show_loaded(map_->collection().size(), problems);
  });
}

/// Adds another flight as the newest one.
bool SubmapIntegratorNodelet::on_merge(mrs_msgs::String::Request& request, mrs_msgs::String::Response& response) {
  return answer(&response, [&] {
    const auto [directory, T_W_other] = directory_and_pose(request.value);
    std::vector<std::string> problems;
    const auto other = submap::SubmapCollection::load(directory, &problems, &collection_config_);
    const std::lock_guard<std::mutex> lock(mutex_);
    map_->collection().merge(other, T_W_other);
    continue_from(map_->collection());
    return show_loaded(other.size(), problems);
  });
}

bool SubmapIntegratorNodelet::on_export(mrs_msgs::String::Request& request, mrs_msgs::String::Response& response) {
  return answer(&response, [&] {
    submap::SubmapCollection copy = copy_of_map();
    const auto shift_m = submap::export_all(&copy, request.value);
    std::ostringstream said;
    said << "mesh.ply, occupied.ply, map.ot and clouds of the submaps are in " << request.value;
    if (shift_m) said << "; add (" << shift_m->transpose() << ") m to coordinates in map.ot, which was shifted";
    return said.str();
  });
}

}  // namespace voxnav_ros
