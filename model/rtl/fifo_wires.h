#pragma once

#include <cstdint>
#include <memory>
#include <systemc>

#include "rtl/pins.h"
#include "rtl/signals.h"
#include "rtl/wire.h"

namespace metabuffer::rtl {

/// The further pins of a composer's FIFO whose window holds two source rows: a second read port, and at both ports the
/// word after the one that is read. Consecutive words lie in different block RAMs, so one port reads both.
struct SecondRowPins {
    Out<std::uint64_t> next_word_o{"next_word_o"};  ///< after the one at word_o
    In<FifoRead> row_read_i{"row_read_i"};
    Out<std::uint64_t> row_word_o{"row_word_o"};
    Out<std::uint64_t> row_next_word_o{"row_next_word_o"};
};

/// The wires between a composer and its FIFO.
struct FifoWires {
    /// Of SecondRowPins.
    struct SecondRow {
        Wire<std::uint64_t> next_word{"fifo_next_word"};
        Wire<FifoRead> read{"fifo_row_read"};
        Wire<std::uint64_t> word{"fifo_row_word"};
        Wire<std::uint64_t> row_next_word{"fifo_row_next_word"};
    };

    /// window_rows: source rows in the composer's window, 1 or 2.
    explicit FifoWires(int window_rows = 1)
        : second_row(window_rows > 1 ? std::make_unique<SecondRow>() : nullptr) {}

    Wire<FifoWrite> write{"fifo_write"};
    Wire<FifoRead> read{"fifo_read"};
    Wire<FifoRelease> release{"fifo_release"};
    Wire<std::uint64_t> word{"fifo_word"};
    Wire<std::uint32_t> free{"fifo_free"};
    std::unique_ptr<SecondRow> second_row;  ///< null with a window of one row
};

}  // namespace metabuffer::rtl
