#pragma once

#include <systemc>

#include "rtl/composer_signals.h"
#include "rtl/fifo_wires.h"
#include "rtl/wire.h"

namespace metabuffer::rtl {

/// Every wire between two of the blocks that a composer is made of.
struct ComposerWires {
    /// window_rows: source rows in the window, 1 or 2.
    explicit ComposerWires(int window_rows) : fifo(window_rows) {}

    FifoWires fifo;
    // beat_receiver to the others
    Wire<HeadSegment> segment{"segment"};
    Wire<SegmentProgress> progress{"progress"};
    Wire<bool> fetched{"fetched"};
    // raster_walker to the others
    Wire<bool> running{"running"};
    Wire<RasterStep> ahead{"ahead"};
    Wire<bool> uses{"uses"};
    Wire<PixelUse> use{"use"};
    // merge_stage to what records
    Wire<bool> missing{"missing"};
    // pipeline_handshake to the others
    Wire<bool> start{"start"};
};

}  // namespace metabuffer::rtl
