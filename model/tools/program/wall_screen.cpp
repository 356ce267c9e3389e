#include "tools/program/wall_screen.h"

#include <algorithm>
#include <cstdint>
#include <iostream>
#include <numeric>

#include "host/errors.h"
#include "host/text.h"
#include "report/picture_writer.h"

namespace metabuffer {
namespace {

constexpr std::uint32_t kMark = 0xFF00FF;

}  // namespace

WallScreen::WallScreen(const Scenario& scenario, const std::string& video, bool window)
    : scenario_(scenario),
      displays_(static_cast<std::size_t>(scenario.displays.count()),
                ColourImage(scenario.displays.width_pixels, scenario.displays.height_pixels)),
      marked_(displays_),
      frames_(displays_.size(), -1),
      starved_pixels_(displays_.size()),
      wrong_pixels_(displays_.size()),
      video_name_(video == "-" ? "standard output" : video) {
    if (!video.empty()) {
        video_ = &std::cout;
        if (video != "-") {
            video_file_.open(video, std::ios::binary);
            video_ = &video_file_;
            if (!video_file_) throw OutputError(text::located(video_name_, "cannot be written"));
        }
    }
    if (window) window_ = WallWindow::open("Metabuffer: " + scenario.name, why_no_window_);
}

void WallScreen::take(const DisplayedFrame& displayed, const std::vector<std::size_t>& wrong_pixels) {
    const auto index = static_cast<std::size_t>(displayed.display) - 1;
    displays_[index] = displayed.picture;
    if (window_) {
        marked_[index] = displayed.picture;
        for (const std::size_t pixel : wrong_pixels) marked_[index].values[pixel] = kMark;
    }
    frames_[index] = displayed.frame;
    starved_pixels_[index] = displayed.starved_pixels;
    wrong_pixels_[index] = static_cast<std::int64_t>(wrong_pixels.size());
    const bool all =
        std::all_of(frames_.begin(), frames_.end(), [&](int frame) { return frame == displayed.frame; });
    if (!all) return;
    if (video_ != nullptr) write(collage(displays_, scenario_.displays, 0));
    if (window_) {
        const auto sum = [](const std::vector<std::int64_t>& counts) {
            return std::to_string(std::accumulate(counts.begin(), counts.end(), std::int64_t{0}));
        };
        window_->show(collage(displays_, scenario_.displays), collage(marked_, scenario_.displays),
                      ", frame " + std::to_string(displayed.frame) + ": " + sum(starved_pixels_) +
                          " pixels starved, " + sum(wrong_pixels_) + " wrong");
        poll();
    }
}

void WallScreen::poll() {
    if (!window_ || window_->poll()) return;
    window_.reset();
    if (end_) end_();
}

void WallScreen::write(const ColourImage& picture) {
    bytes_.clear();
    for (const std::uint32_t colour : picture.values) {
        for (const unsigned shift : {16U, 8U, 0U}) bytes_ += static_cast<char>(colour >> shift & 0xFFU);
    }
    video_->write(bytes_.data(), static_cast<std::streamsize>(bytes_.size()));
    if (!video_->flush()) throw OutputError(text::located(video_name_, "cannot be written"));
}

}  // namespace metabuffer
