#include "tools/program/wrong_pixel_record.h"

namespace metabuffer {

const std::vector<std::size_t>& WrongPixelRecord::take(const DisplayedFrame& displayed) {
    found_.clear();
    // If `kept` is set, the display shows an earlier frame instead, whether this one starved or not.
    const bool may_be_wrong = (displayed.starved_pixels > 0 || links_err_) && !displayed.kept;
    const auto known = counts_.find(displayed.frame);
    if (!may_be_wrong && known == counts_.end()) return found_;
    std::vector<std::int64_t>& counts = counts_.try_emplace(displayed.frame, displays_).first->second;
    if (may_be_wrong) {
        found_ = wrong_pixels_.find(displayed.frame, displayed.display, displayed.picture, displayed.pairs);
    }
    // After a reset a frame may come again; its new count replaces the old one.
    counts[static_cast<std::size_t>(displayed.display) - 1] = static_cast<std::int64_t>(found_.size());
    return found_;
}

void WrongPixelRecord::put_into(RunReport& report) const {
    for (FrameRecord& frame : report.frames) {
        const auto counts = counts_.find(frame.index);
        frame.wrong_pixels = counts == counts_.end() ? std::vector<std::int64_t>(displays_) : counts->second;
    }
}

}  // namespace metabuffer
