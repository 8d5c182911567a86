// SPDX-License-Identifier: BSD-3-Clause
#include "submap/content/content_codec.hpp"

#include <utility>

namespace voxnav::submap {
namespace {

using geometry::Index3;

template <class T>
void put_all(const std::vector<T>& items, base::ByteWriter* out) {
  out->put<std::uint64_t>(items.size());
  out->put_raw(items.data(), items.size() * sizeof(T));
}
template <class T>
void get_all(base::ByteReader* in, std::vector<T>* items) {
  items->resize(in->get_count(sizeof(T)));
  in->get_raw(items->data(), items->size() * sizeof(T));
}

void put_states(const BlockStates& states, base::ByteWriter* out) {
  out->put<std::uint64_t>(states.size());
  for (const BlockStates::Block& block : states.blocks()) {
    out->put(block.index);
    for (const std::uint64_t cells :
         {block.occupied_cells, block.open_cells, block.mixed_cells, block.observed_cells, block.partly_observed_cells})
      out->put(cells);
  }
  put_all(states.occupied_words(), out);
  put_all(states.mixed_words(), out);
  put_all(states.observed_words(), out);
}

BlockStates get_states(base::ByteReader* in) {
  BlockStates::Parts parts;
  parts.blocks.resize(in->get_count(sizeof(Index3) + 5 * sizeof(std::uint64_t)));
  for (BlockStates::Block& block : parts.blocks) {
    block.index = in->get<Index3>();
    for (std::uint64_t* cells : {&block.occupied_cells, &block.open_cells, &block.mixed_cells, &block.observed_cells,
                                 &block.partly_observed_cells})
      *cells = in->get<std::uint64_t>();
  }
  get_all(in, &parts.occupied);
  get_all(in, &parts.mixed);
  get_all(in, &parts.observed_free);
  BlockStates states;
  if (const char* problem = states.assign(std::move(parts))) in->fail(problem);
  return states;
}

void put_points(const VoxelPoints& points, base::ByteWriter* out) {
  put_all(points.all_believed(), out);
  put_all(points.times(), out);
  put_all(points.differing(), out);
  for (const RankedBits* bits : {&points.observed_bits(), &points.differing_bits()})
    out->put_raw(bits->words().data(), bits->words().size() * sizeof(std::uint64_t));
}

VoxelPoints get_points(base::ByteReader* in) {
  VoxelPoints::Parts parts;
  get_all(in, &parts.believed);
  get_all(in, &parts.times);
  get_all(in, &parts.observed);
  const auto get_words = [in](std::size_t num_bits, std::vector<std::uint64_t>* words) {
    words->resize((num_bits + 63) / 64);
    in->get_raw(words->data(), words->size() * sizeof(std::uint64_t));
  };
  get_words(parts.believed.size(), &parts.observed_words);
  get_words(parts.times.size(), &parts.differing_words);
  VoxelPoints points;
  if (!points.assign(std::move(parts))) in->fail("has observed points that do not match its occupied voxels");
  return points;
}

void put_measured(const MeasuredDistances* measured, base::ByteWriter* out) {
  out->put<std::uint8_t>(measured ? 1 : 0);
  if (!measured) return;
  const std::vector<std::uint64_t> cells_of_blocks = measured->cells_of_blocks();
  out->put_raw(cells_of_blocks.data(), cells_of_blocks.size() * sizeof(std::uint64_t));
  put_all(measured->cells(), out);
}

std::optional<MeasuredDistances> get_measured(std::size_t num_blocks, double band, base::ByteReader* in) {
  const auto has_measured = in->get<std::uint8_t>();
  if (has_measured > 1) in->fail("does not say whether it holds distances");
  if (has_measured == 0) return std::nullopt;
  if (num_blocks > in->remaining() / sizeof(std::uint64_t)) in->fail("ends before its distances");
  std::vector<std::uint64_t> cells_of_blocks(num_blocks);
  in->get_raw(cells_of_blocks.data(), cells_of_blocks.size() * sizeof(std::uint64_t));
  std::vector<MeasuredDistances::Cell> cells;
  get_all(in, &cells);
  MeasuredDistances measured(band);
  if (!measured.assign(cells_of_blocks, std::move(cells))) in->fail("has distances that do not match its blocks");
  return measured;
}

}  // namespace

void write_content(const SubmapContent& content, base::ByteWriter* out) {
  out->put(content.band());
  put_states(content.states(), out);
  put_points(content.points(), out);
  put_measured(content.measured(), out);
}

SubmapContent read_content(base::ByteReader* in) {
  constexpr double kWidestBand = 6.0;  // limit of SubmapConfig; the halo of ContentWindow holds no wider band
  const auto band = in->get<double>();
  if (!(band >= 1.0 && band <= kWidestBand)) in->fail("has no usable distance band");
  BlockStates states = get_states(in);
  VoxelPoints points = get_points(in);
  if (points.size() != states.num_occupied()) in->fail("has surface points that do not match its states");
  std::optional<MeasuredDistances> measured = get_measured(states.size(), band, in);
  return {std::move(states), std::move(points), std::move(measured), band};
}

}  // namespace voxnav::submap
