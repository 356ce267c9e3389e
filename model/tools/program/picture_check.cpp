#include "tools/program/picture_check.h"

#include <algorithm>

#include "host/child_process.h"
#include "host/text.h"
#include "monitors/picture_reference.h"

namespace metabuffer {
namespace {

/// Whether a pixel of a display's frame starved, or may have starved: if there are very many starved runs, only the
/// first are known.
bool may_have_starved(const RunReport& report, int frame, int display) {
    return std::any_of(report.composers.begin(), report.composers.end(),
                       [=](const ComposerCounters& composer) {
                           if (composer.display != display || composer.starved_pixels == 0) return false;
                           const bool cut_off = composer.starved_run_count > kStarvedRunsKept;
                           return (cut_off && !composer.starved_runs.empty() &&
                                   frame >= composer.starved_runs.back().frame) ||
                                  std::any_of(composer.starved_runs.begin(), composer.starved_runs.end(),
                                              [=](const StarvedRun& run) { return run.frame == frame; });
                       });
}

/// Which picture of the run: its name for PictureProcesses.
struct PictureKey {
    int frame;
    int display;
};

std::string name_of(const PictureKey& key) {
    return std::to_string(key.frame) + " " + std::to_string(key.display);
}

PictureKey key_of(const std::string& name) {
    const std::size_t space = name.find(' ');
    return {std::stoi(name.substr(0, space)), std::stoi(name.substr(space))};
}

}  // namespace

PictureCheck::PictureCheck(const Scenario& scenario)
    : scenario_(scenario),
      pairs_without_time_(functional::pairs_without_time(scenario)),
      compositor_(scenario),
      processes_(
          extent(scenario.displays),
          [this](const std::string& name, const ColourImage& picture) {
              const PictureKey key = key_of(name);
              return !(picture == wanted(key.frame, key.display));
          },
          [this](const std::string& name, const ColourImage& picture) {
              const PictureKey key = key_of(name);
              keep(key.frame, key.display, picture);
          }) {}

/// One process, which holds the pictures of a frame, unless these are very large.
PictureProcesses::Extent PictureCheck::extent(const DisplayConfig& displays) {
    constexpr std::size_t kMostBytesHeld = std::size_t{64} << 20;
    PictureProcesses::Extent extent;
    extent.processes = std::min(helper_process_count(), std::size_t{1});
    extent.pixels_of_largest =
        static_cast<std::size_t>(displays.width_pixels) * static_cast<std::size_t>(displays.height_pixels);
    extent.pictures_each = std::clamp(kMostBytesHeld / (extent.pixels_of_largest * sizeof(std::uint32_t)),
                                      std::size_t{1}, static_cast<std::size_t>(displays.count()));
    return extent;
}

ColourImage PictureCheck::wanted(int frame, int display) {
    if (frame != compositor_frame_) {
        compositor_.begin_frame(
            functional::contributions_of(scenario_, pairs_without_time_[static_cast<std::size_t>(frame)]));
        compositor_frame_ = frame;
    }
    return compositor_.picture(display);
}

void PictureCheck::take(int frame, int display, const ColourImage& picture) {
    ++taken_;
    processes_.take(name_of({frame, display}), picture);
}

void PictureCheck::keep(int frame, int display, const ColourImage& picture) {
    const std::size_t bytes = picture.values.size() * sizeof(picture.values.front());
    if (kept_bytes_ + bytes > kKeptBytes) {
        not_kept_.insert({frame, display});
        return;
    }
    kept_bytes_ += bytes;
    kept_[{frame, display}] = picture;
}

void PictureCheck::finish(const RunReport& report) {
    processes_.finish();
    for (const FrameRecord& frame : report.frames) {
        const bool as_without_time =
            frame.pairs == pairs_without_time_[static_cast<std::size_t>(frame.index)];
        for (int display = 1; display <= scenario_.displays.count(); ++display) {
            if (not_kept_.count({frame.index, display}) > 0) continue;
            const auto kept = kept_.find({frame.index, display});
            if (kept != kept_.end()) {
                judge(frame.index, display, kept->second, frame.pairs, report);
            } else if (!as_without_time) {
                judge(frame.index, display, wanted(frame.index, display), frame.pairs, report);
            }
        }
    }
    const auto not_kept = static_cast<std::int64_t>(not_kept_.size());
    record_.pictures = taken_ - starved_ - not_kept;
    compared_ = std::to_string(record_.pictures) + " of " + std::to_string(taken_) +
                " pictures against the functional level";
    std::vector<std::string> why_others_not;
    if (not_kept > 0) {
        why_others_not.push_back(std::to_string(not_kept) + " of the others were too many to be kept");
    }
    if (starved_ > 0) why_others_not.emplace_back("in the others something starved");
    if (!why_others_not.empty()) compared_ += " (" + text::joined(why_others_not, "and") + ")";
    compared_ += ", and no wires, which only level rtl has";
}

void PictureCheck::judge(int frame, int display, const ColourImage& picture, const std::vector<int>& pairs,
                         const RunReport& report) {
    const ColourImage right =
        functional::composite_display(scenario_, functional::contributions_of(scenario_, pairs), display);
    const auto fault = monitors::picture_fault(picture, right);
    if (!fault) return;
    if (may_have_starved(report, frame, display)) {
        ++starved_;
        return;
    }
    record_.add("scoreboard/picture: display " + std::to_string(display) + ", frame " +
                std::to_string(frame) + ": " + *fault);
}

}  // namespace metabuffer
