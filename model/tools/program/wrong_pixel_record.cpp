#include "tools/program/wrong_pixel_record.h"

namespace metabuffer {

void WrongPixelRecord::take(const DisplayedFrame& displayed) {
    // If `kept` is set, the display shows an earlier frame instead, whether this one starved or not.
    const bool may_be_wrong = (displayed.starved_pixels > 0 || links_err_) && !displayed.kept;
    const auto known = counts_.find(displayed.frame);
    if (!may_be_wrong && known == counts_.end()) return;
    std::vector<std::int64_t>& counts = counts_.try_emplace(displayed.frame, displays_).first->second;
    // After a reset a frame may come again; its new count replaces the old one.
    counts[static_cast<std::size_t>(displayed.display) - 1] =
        may_be_wrong
            ? wrong_pixels_.count(displayed.frame, displayed.display, displayed.picture, displayed.pairs)
            : 0;
}

void WrongPixelRecord::put_into(RunReport& report) const {
    for (FrameRecord& frame : report.frames) {
        const auto counts = counts_.find(frame.index);
        frame.wrong_pixels = counts == counts_.end() ? std::vector<std::int64_t>(displays_) : counts->second;
    }
}

}  // namespace metabuffer
