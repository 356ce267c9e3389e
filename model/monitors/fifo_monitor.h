#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <systemc>
#include <vector>

#include "monitors/rule_reporter.h"
#include "monitors/violation.h"
#include "rtl/block.h"
#include "rtl/signals.h"
#include "scenario/scenario.h"

namespace metabuffer::monitors {

/// Checks a composer's FIFO (section 5.2 of the paper) from outside, at each edge of the core clock: the composer's
/// commands to it, and its outputs. The monitor keeps the held pixels as a list of addresses.
///
/// Rules:
/// - fifo/overwrite: a word is written to an address that holds none, so nothing in the window is lost
/// - fifo/read: what is read is held, or comes at the edge that reads it
/// - fifo/release: no more is released than is held
/// - fifo/word: WORD is what was written to the address read last; with a window of two rows, the same at both ports, and
///   for the address after it
/// - fifo/free: FREE is the capacity less what is held
class FifoMonitor final : public sc_core::sc_module {
  public:
    sc_core::sc_in<bool> clk_i{"clk_i"};      ///< core clock
    sc_core::sc_in<bool> reset_i{"reset_i"};  ///< synchronous, active high
    sc_core::sc_in<rtl::FifoWrite> write_i{"write_i"};
    sc_core::sc_in<rtl::FifoRead> read_i{"read_i"};
    sc_core::sc_in<rtl::FifoRelease> release_i{"release_i"};
    sc_core::sc_in<std::uint64_t> word_i{"word_i"};
    sc_core::sc_in<std::uint32_t> free_i{"free_i"};

    /// With a window of two rows.
    struct SecondRow {
        sc_core::sc_in<std::uint64_t> next_word_i{"next_word_i"};
        sc_core::sc_in<rtl::FifoRead> row_read_i{"row_read_i"};
        sc_core::sc_in<std::uint64_t> row_word_i{"row_word_i"};
        sc_core::sc_in<std::uint64_t> row_next_word_i{"row_next_word_i"};
    };
    std::unique_ptr<SecondRow> second_row;

    /// composer: its name, for the violations.
    FifoMonitor(const sc_core::sc_module_name& name, const Scenario& scenario, const std::string& composer,
                ViolationLog& log);

    /// Violations that were seen and not reported, since one of the same rule was.
    std::int64_t unreported() const { return reporter_.unreported(); }
    std::int64_t pixels_written() const { return pixels_written_; }

  private:
    struct Word {
        bool held = false;
        std::uint64_t value = 0;
    };

    void clock_edge();
    void restart();
    void check_outputs(std::int64_t edge);
    void take_release(const rtl::FifoRelease& release, std::int64_t edge);
    void take_write(const rtl::FifoWrite& write, std::int64_t edge);
    /// What stands at a read port.
    struct Port {
        std::optional<std::uint64_t> word = 0;
        std::optional<std::uint64_t> next_word = 0;  ///< none if what was read holds no pixel
    };
    void check_word(std::uint64_t seen, const std::optional<std::uint64_t>& expected, const char* signal,
                    std::int64_t edge);
    void take_read(const rtl::FifoRead& read, const char* signal, Port& port, std::int64_t edge);
    void violate(const char* rule, const char* signal, std::int64_t edge, const std::string& detail);

    std::string fifo_;
    std::uint32_t capacity_;
    std::int64_t core_period_picoseconds_;
    RuleReporter reporter_;

    std::vector<Word> words_;         ///< by address
    std::deque<std::uint32_t> held_;  ///< addresses, the oldest pixel's first
    bool started_ = false;            ///< there has been an edge without reset
    Port port_;
    Port row_port_;
    std::int64_t pixels_written_ = 0;
    rtl::Clocked clocked_{*this, clk_i, &FifoMonitor::clock_edge};
};

}  // namespace metabuffer::monitors
