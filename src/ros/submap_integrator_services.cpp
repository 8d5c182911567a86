// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cstdio>
#include <regex>
#include <sstream>

#include "submap_integrator_nodelet.hpp"
#include "voxnav/occupancy/octomap_export.hpp"
#include "voxnav/submap/submap_collection.hpp"
#include "voxnav_ros/submap_conversions.hpp"

namespace voxnav_ros {
namespace {

/// Answers a request with what `work` returns, or with the reason why it threw.
template <class Response, class Work>
bool answer(Response* response, Work&& work) {
  try {
    response->message = work();
    response->success = true;
  } catch (const std::exception& error) {
    response->message = error.what();
    response->success = false;
  }
  return true;
}

/// Reads "PATH" or "PATH x y z yaw", in metres and radians. A path may hold spaces.
std::pair<std::string, voxnav::geometry::Pose> path_and_pose(const std::string& text) {
  static const std::regex kNumbers(R"((.*\S)\s+(\S+)\s+(\S+)\s+(\S+)\s+(\S+))");
  static const std::regex kEndsInNumber(R"(.*\s[-+.\d]+)");
  std::smatch parts;
  if (std::regex_match(text, parts, kNumbers)) {
    std::istringstream in(parts.str(2) + " " + parts.str(3) + " " + parts.str(4) + " " + parts.str(5));
    voxnav::geometry::Vec3 position;
    double yaw = 0.0;
    if (in >> position.x() >> position.y() >> position.z() >> yaw && in.eof()) {
      return {parts.str(1), voxnav::geometry::from_position_yaw(position, yaw)};
    }
  }
  if (std::regex_match(text, kEndsInNumber)) throw std::invalid_argument("a map is given as: PATH [x y z yaw]");
  return {text, voxnav::geometry::Pose::Identity()};
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

/// Writes the map for OctoMap. The file is complete before it gets its name.
std::string SubmapIntegratorNodelet::save_octomap(const std::string& path) {
  submap::SubmapCollection copy = copy_of_map();
  copy.update();
  const std::lock_guard<std::mutex> lock(save_mutex_);
  const std::string unfinished = path.substr(0, path.size() - 3) + ".tmp" + path.substr(path.size() - 3);
  const auto shift_m = submap::save_octomap(copy.evidence(), unfinished);
  if (std::rename(unfinished.c_str(), path.c_str()) != 0) throw std::runtime_error(path + ": cannot be written");
  std::ostringstream said;
  said << copy.size() << " submaps saved to " << path;
  if (shift_m) said << "; add (" << shift_m->transpose() << ") m to its coordinates, which were shifted";
  return said.str();
}

/// Saves all submaps to a folder, or the merged map as an OctoMap to a file that ends in .ot or .bt.
bool SubmapIntegratorNodelet::on_save(mrs_msgs::String::Request& request, mrs_msgs::String::Response& response) {
  return answer(&response, [&] {
    if (voxnav::occupancy::is_octomap_path(request.value)) return save_octomap(request.value);
    return std::to_string(save(request.value)) + " submaps saved to " + request.value;
  });
}

/// Ensures that the next submap belongs to a newer flight than all loaded ones and gets an unused id.
void SubmapIntegratorNodelet::continue_from(const submap::SubmapCollection& loaded) {
  if (loaded.size() == 0) return;  // ids of submaps that the optimiser knows must not be used again
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

submap::SubmapCollection SubmapIntegratorNodelet::load(const std::string& path,
                                                       std::vector<std::string>* problems) const {
  if (voxnav::occupancy::is_octomap_path(path)) return submap::load_octomap(path, collection_config_, submap_config_);
  return submap::SubmapCollection::load(path, problems, &collection_config_);
}

std::string SubmapIntegratorNodelet::take_over(submap::SubmapCollection loaded,
                                               const std::vector<std::string>& problems) {
  const std::lock_guard<std::mutex> lock(mutex_);
  continue_from(loaded);
  map_->replace(std::move(loaded));
  return show_loaded(map_->collection().size(), problems);
}

/// Loads a map from a folder or an OctoMap file in place of the present one, moved by a pose if one is given. Broken
/// parts of the files are left out, and the answer tells which. Limits and page_dir stay those of this node.
bool SubmapIntegratorNodelet::on_load(mrs_msgs::String::Request& request, mrs_msgs::String::Response& response) {
  return answer(&response, [&] {
    const auto [path, T_W_other] = path_and_pose(request.value);
    std::vector<std::string> problems;
    submap::SubmapCollection loaded = load(path, &problems);
    if (T_W_other.isApprox(voxnav::geometry::Pose::Identity())) return take_over(std::move(loaded), problems);
    submap::SubmapCollection moved(collection_config_);
    moved.merge(loaded, T_W_other);
    return take_over(std::move(moved), problems);
  });
}

/// Adds another flight as the newest one.
bool SubmapIntegratorNodelet::on_merge(mrs_msgs::String::Request& request, mrs_msgs::String::Response& response) {
  return answer(&response, [&] {
    const auto [path, T_W_other] = path_and_pose(request.value);
    std::vector<std::string> problems;
    const submap::SubmapCollection other = load(path, &problems);
    const std::lock_guard<std::mutex> lock(mutex_);
    map_->collection().merge(other, T_W_other);
    continue_from(map_->collection());
    return show_loaded(other.size(), problems);
  });
}

/// Forgets all submaps, and those that were handed over before but come later.
bool SubmapIntegratorNodelet::on_reset(std_srvs::Trigger::Request&, std_srvs::Trigger::Response& response) {
  return answer(&response, [&] {
    take_over(submap::SubmapCollection(collection_config_), {});
    const std::lock_guard<std::mutex> lock(mutex_);
    reset_at_ = ros::Time::now();
    return std::string("map cleared");
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
