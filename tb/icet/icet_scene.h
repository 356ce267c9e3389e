#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "functional/functional_compositor.h"
#include "scenario/scenario.h"

/// What both compositors get: the images that renderers contribute to one frame, as IceT takes them.
namespace metabuffer::icet {

/// The most renderers, and so processes.
constexpr std::size_t kMostRanks = 8;

/// One frame of a scenario, with where its images come from.
struct Scene {
    std::string name;
    const Scenario* scenario = nullptr;
    std::vector<functional::Contribution> contributions;
};

/// The raster of the whole wall, displays without gaps between them.
struct WallSize {
    int width_pixels = 0;
    int height_pixels = 0;

    std::size_t pixels() const {
        return static_cast<std::size_t>(width_pixels) * static_cast<std::size_t>(height_pixels);
    }
};
WallSize wall_size(const DisplayConfig& displays);

/// An image of the whole wall: R, G, B, A in the order of bytes, and depths from 0 to 1. Depth 1 is the far plane, where
/// nothing is. A Z of up to 24 bits is a multiple of 2^-24, which a float holds exactly.
struct WallImage {
    std::vector<std::uint8_t> rgba;
    std::vector<float> depths;
    /// x, y, width, height of what is not at the far plane.
    int viewport[4] = {0, 0, 0, 0};
};

/// What a contribution shows on the wall. Each raster pixel looks up its source pixel, by a division; magnified images
/// become full ones, since IceT knows no magnification.
WallImage placed(const Scene& scene, std::size_t renderer);

/// The Z of a depth, far for 1.
std::uint32_t z_of(float depth, std::uint32_t far);

/// A scenario of the same displays, whose renderers have these images at 0,0 of the wall, 1:1.
Scenario scenario_of(const std::vector<WallImage>& images, const Scenario& of);

/// A random wall with `renderers` images that lie anywhere, magnified or not. No two renderers have the same Z, except
/// for the far plane.
Scenario random_wall(std::uint64_t seed, std::size_t renderers);

}  // namespace metabuffer::icet
