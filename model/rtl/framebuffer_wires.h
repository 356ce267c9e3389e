#pragma once

#include <cstddef>
#include <cstdint>
#include <systemc>

#include "rtl/signals.h"
#include "rtl/wire.h"
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
    Wire<bool> request{"request"};
    Wire<bool> answer{"answer"};
    Wire<bool> fresh{"fresh"};
    Wire<bool> front{"front"};
    Wire<MemoryWrite> write{"write"};
    Wire<FrontTable> table{"table"};
    // bus_port, memory_controller and frame_memory
    Wire<MemoryRequest> memory_request{"memory_request"};
    Wire<MemoryAnswer> memory_answer{"memory_answer"};
    Wire<MemoryCommand> command{"command"};
    Wire<MemoryData> data{"data"};
    // bus_port and bus_arbiter
    Wire<bool> start{"start"};
    Wire<bool> take{"take"};
    SignalArray<bool> pending;
    SignalArray<bool> ready;
    SignalArray<std::uint64_t> deadline;
    SignalArray<bool> grant;
    Wire<bool> grant_valid{"grant_valid"};
    Wire<bool> search{"search"};
    Wire<bool> lost{"lost"};
    Wire<std::uint16_t> recovered{"recovered"};
    Wire<std::uint16_t> slot{"slot"};
    // write_buffer, memory_controller and frame_memory
    SignalArray<bool> write_full;
    SignalArray<WriteBlock> write_block;
    Wire<bool> drain{"drain"};
    Wire<MemoryData> write_data{"write_data"};
};

}  // namespace metabuffer::rtl
