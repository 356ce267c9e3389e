#include "tools/program/picture_check.h"

#include <algorithm>

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

}  // namespace

PictureCheck::PictureCheck(const Scenario& scenario)
    : scenario_(scenario),
      pairs_without_time_(functional::pairs_without_time(scenario)),
      compositor_(scenario) {}

const ColourImage& PictureCheck::wanted(int frame, int display) {
    if (frame != compositor_frame_) {
        compositor_.begin_frame(
            functional::contributions_of(scenario_, pairs_without_time_[static_cast<std::size_t>(frame)]));
        compositor_frame_ = frame;
    }
    wanted_ = compositor_.picture(display);
    return wanted_;
}

void PictureCheck::take(int frame, int display, const ColourImage& picture) {
    ++taken_;
    if (picture == wanted(frame, display)) return;
    const std::size_t bytes = picture.values.size() * sizeof(picture.values.front());
    if (kept_bytes_ + bytes > kKeptBytes) {
        not_kept_.insert({frame, display});
        return;
    }
    kept_bytes_ += bytes;
    kept_[{frame, display}] = picture;
}

void PictureCheck::finish(const RunReport& report) {
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
