#pragma once

#include <algorithm>
#include <cstdint>
#include <tuple>

#include "report/composer_record.h"

namespace metabuffer {

/// Something that happens once in a run: its core clock, and the composer that it concerns.
struct MachineEvent {
    std::int64_t cycle = ComposerRecord::kNever;
    int renderer = 0;  ///< of the composer, from 1; so is display
    int display = 0;

    bool happened() const { return cycle != ComposerRecord::kNever; }
};

/// The earlier of two. Of two in one clock it is that of the first renderer, then of the first display.
inline MachineEvent earlier(const MachineEvent& a, const MachineEvent& b) {
    if (!a.happened() || !b.happened()) return a.happened() ? a : b;
    return std::min(a, b, [](const MachineEvent& one, const MachineEvent& other) {
        return std::tie(one.cycle, one.renderer, one.display) <
               std::tie(other.cycle, other.renderer, other.display);
    });
}

}  // namespace metabuffer
