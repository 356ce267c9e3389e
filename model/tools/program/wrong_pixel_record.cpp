#include "tools/program/wrong_pixel_record.h"

namespace metabuffer {

void WrongPixelRecord::take(const DisplayedFrame& displayed) {
    // What was kept off is not shown, starved or not.
    if (displayed.starved_pixels == 0 || displayed.kept) return;
    std::vector<std::int64_t>& counts = counts_.try_emplace(displayed.frame, displays_).first->second;
    counts[static_cast<std::size_t>(displayed.display) - 1] =
        wrong_pixels_.count(displayed.frame, displayed.display, displayed.picture, displayed.pairs);
}

void WrongPixelRecord::put_into(RunReport& report) const {
    for (FrameRecord& frame : report.frames) {
        const auto counts = counts_.find(frame.index);
        frame.wrong_pixels = counts == counts_.end() ? std::vector<std::int64_t>(displays_) : counts->second;
    }
}

}  // namespace metabuffer
