#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <string>
#include <systemc>
#include <vector>

#include "monitors/rule_reporter.h"
#include "monitors/violation.h"
#include "rtl/block.h"
#include "rtl/signals.h"
#include "scenario/scenario.h"

namespace metabuffer::monitors {

/// Checks an input framebuffer's memory (sections 4 and 5.2 of the paper) from outside: what the link writes, the bus
/// port's commands, and the words that come for them. The monitor keeps what is stored, which pages are open and when a
/// refresh is due.
///
/// Rules:
/// - memory/device: the link writes the device that the bus does not read
/// - memory/open: a read or write is of the page that is open in its bank; where an activation takes no clock, it opens
///   the page itself
/// - memory/write: with shared ports each word of the link's whole blocks is written once, in order and unchanged, into
///   the image that is not read; no third block begins while two wait
/// - memory/activate: a page is opened in the bank that it lies in, and only if that bank was closed precharge_cycles
///   before or earlier
/// - memory/timing: with precharge_cycles, a read or write comes at the earliest activate_cycles after its page's
///   activate, or precharge_cycles after the bank's precharge where an activate takes no clock
/// - memory/refresh: a refresh comes every refresh_interval_cycles and at no other time; no command comes in its
///   refresh_cycles
/// - memory/data: the words of a read come read_latency_cycles later, as they were written; none come at other clocks
///
/// Without precharge_cycles a page miss is only a delay: a burst that BUSREADY stops leaves its page open at once, and
/// the next burst may read it.
class MemoryMonitor final : public sc_core::sc_module {
  public:
    sc_core::sc_in<bool> clk_i{"clk_i"};              ///< core clock
    sc_core::sc_in<bool> reset_i{"reset_i"};          ///< synchronous, active high
    sc_core::sc_in<bool> write_clk_i{"write_clk_i"};  ///< the link's clock
    sc_core::sc_in<rtl::MemoryWrite> write_i{"write_i"};
    sc_core::sc_in<bool> front_i{"front_i"};
    sc_core::sc_in<rtl::MemoryCommand> command_i{"command_i"};
    sc_core::sc_in<rtl::MemoryData> data_i{"data_i"};
    sc_core::sc_vector<sc_core::sc_in<rtl::MemoryData>> write_data_i;  ///< one, only with shared ports

    /// renderer: index, from 0.
    MemoryMonitor(const sc_core::sc_module_name& name, const Scenario& scenario, int renderer,
                  ViolationLog& log);

    std::int64_t words_read() const { return words_read_; }
    /// Violations that were seen and not reported, since one of the same rule was.
    std::int64_t unreported() const { return reporter_.unreported(); }

  private:
    static constexpr std::int64_t kNone = -1;

    struct Bank {
        std::int64_t page = kNone;
        std::int64_t closed_at = kNone;     ///< edge of the precharge that has closed it
        std::int64_t activated_at = kNone;  ///< edge of the activate that has opened its page
    };

    void write_edge();
    void clock_edge();
    void restart();
    void check_data(const rtl::MemoryData& wanted, std::int64_t edge);
    void take_command(const rtl::MemoryCommand& command, std::int64_t edge);
    void check_refresh(const rtl::MemoryCommand& command, std::int64_t edge);
    void check_activate(const rtl::MemoryCommand& command, std::int64_t edge);
    void check_open(const rtl::MemoryCommand& command, std::int64_t edge);
    void check_closed(const char* rule, const rtl::MemoryCommand& command, std::int64_t edge);
    void check_write(const rtl::MemoryCommand& command, std::int64_t edge);
    void await_word(const rtl::MemoryWrite& write);
    void close_all(std::int64_t edge);
    rtl::MemoryData words_of(const rtl::MemoryCommand& command) const;
    Bank& bank_of(const rtl::MemoryCommand& command) { return banks_[command.bank % banks_.size()]; }
    void violate(const char* rule, const char* signal, std::int64_t edge, const std::string& detail);

    std::string memory_;
    MemoryConfig config_;
    std::int64_t core_period_picoseconds_;
    RuleReporter reporter_;

    std::array<std::vector<std::uint64_t>, 2> devices_;
    std::int64_t device_words_;  ///< with shared ports: from the first word of one image to that of the other
    /// With shared ports: a word that the link has brought.
    struct Awaited {
        std::int64_t address = 0;  ///< in the memory
        std::uint8_t byte_mask = 0;
        std::uint64_t data = 0;
    };
    std::deque<Awaited> awaited_;
    std::deque<std::size_t> whole_blocks_;  ///< words of each whole block, which come first in awaited_
    std::vector<Bank> banks_;
    std::deque<rtl::MemoryData> due_;       ///< words of the reads on their way, one a clock
    std::int64_t first_edge_ = kNone;       ///< without reset
    std::int64_t refreshed_until_ = kNone;  ///< edge before which the refresh allows no command
    std::int64_t words_read_ = 0;
    rtl::Clocked clocked_{*this, clk_i, &MemoryMonitor::clock_edge};
    rtl::Clocked write_clocked_{*this, write_clk_i, &MemoryMonitor::write_edge};
};

}  // namespace metabuffer::monitors
