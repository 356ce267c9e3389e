#pragma once

#include <systemc>

#include "rtl/composer_signals.h"
#include "rtl/fifo_wires.h"

namespace metabuffer::rtl {

/// Every wire between two of the blocks that a composer is made of.
struct ComposerWires {
    /// window_rows: source rows in the window, 1 or 2.
    explicit ComposerWires(int window_rows) : fifo(window_rows) {}

    FifoWires fifo;
    // beat_receiver to the others
    sc_core::sc_signal<HeadSegment> segment{"segment"};
    sc_core::sc_signal<SegmentProgress> progress{"progress"};
    sc_core::sc_signal<bool> fetched{"fetched"};
    // raster_walker to the others
    sc_core::sc_signal<bool> running{"running"};
    sc_core::sc_signal<RasterStep> ahead{"ahead"};
    sc_core::sc_signal<bool> uses{"uses"};
    sc_core::sc_signal<PixelUse> use{"use"};
    // pipeline_handshake to the others
    sc_core::sc_signal<bool> start{"start"};
};

}  // namespace metabuffer::rtl
