#pragma once

#include <cstddef>
#include <cstdint>
#include <systemc>

#include "rtl/signals.h"
#include "rtl/wires.h"

namespace metabuffer::rtl {

/// Every wire between two of the blocks that an input framebuffer is made of, as its reader sees it.
struct FramebufferWires {
    /// lines: number of displays. halves: number in the write buffer, 0 without one.
    FramebufferWires(int lines, bool deadlines, int halves)
        : pending(static_cast<std::size_t>(lines), Wires::name_of("pending")),
          ready(pending.size(), Wires::name_of("ready")),
          deadline(deadlines ? pending.size() : 0, Wires::name_of("deadline")),
          grant(pending.size(), Wires::name_of("grant")),
          write_full(static_cast<std::size_t>(halves), Wires::name_of("write_full")),
          write_block(write_full.size(), Wires::name_of("write_block")) {}

    // link_port to the others
    sc_core::sc_signal<bool> request{"request"};
    sc_core::sc_signal<bool> answer{"answer"};
    sc_core::sc_signal<bool> fresh{"fresh"};
    sc_core::sc_signal<bool> front{"front"};
    sc_core::sc_signal<MemoryWrite> write{"write"};
    sc_core::sc_signal<FrontTable> table{"table"};
    // bus_port and frame_memory
    sc_core::sc_signal<MemoryCommand> command{"command"};
    sc_core::sc_signal<MemoryData> data{"data"};
    // bus_port and bus_arbiter
    sc_core::sc_signal<bool> start{"start"};
    sc_core::sc_signal<bool> take{"take"};
    SignalBank<bool> pending;
    SignalBank<bool> ready;
    SignalBank<std::uint64_t> deadline;
    SignalBank<bool> grant;
    sc_core::sc_signal<bool> grant_valid{"grant_valid"};
    sc_core::sc_signal<bool> search{"search"};
    sc_core::sc_signal<bool> lost{"lost"};
    sc_core::sc_signal<std::uint16_t> recovered{"recovered"};
    sc_core::sc_signal<std::uint16_t> slot{"slot"};
    // write_buffer to bus_port and frame_memory
    SignalBank<bool> write_full;
    SignalBank<WriteBlock> write_block;
    sc_core::sc_signal<bool> drain{"drain"};
    sc_core::sc_signal<MemoryData> write_data{"write_data"};
};

}  // namespace metabuffer::rtl
