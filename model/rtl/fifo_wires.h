#pragma once

#include <cstdint>
#include <systemc>

#include "rtl/signals.h"

namespace metabuffer::rtl {

/// The wires between a composer and its FIFO.
struct FifoWires {
    sc_core::sc_signal<FifoWrite> write{"fifo_write"};
    sc_core::sc_signal<FifoRead> read{"fifo_read"};
    sc_core::sc_signal<FifoRelease> release{"fifo_release"};
    sc_core::sc_signal<std::uint64_t> word{"fifo_word"};
    sc_core::sc_signal<std::uint32_t> free{"fifo_free"};
};

}  // namespace metabuffer::rtl
