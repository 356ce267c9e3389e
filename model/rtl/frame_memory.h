#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "formats/pixel.h"
#include "rtl/block.h"
#include "rtl/countdown.h"
#include "rtl/memory_bank.h"
#include "rtl/register.h"
#include "rtl/signals.h"

namespace metabuffer::rtl {

/// The 64-bit page-mode memory of an input framebuffer (sections 4 and 5.2 of the paper), with one pixel per word; the
/// colour half and the depth half of a word are written separately. It has two separate devices: the link writes one,
/// and the bus reads the other, which front_i names. So the two never disturb each other. With `memory.ports: shared`
/// it is one device with room for both images and one set of data pins; the link's words wait in write_buffer until the
/// pins are free.
///
/// Unless ports are shared, the link's side stores a write at the link clock that samples it. The bus's side takes one
/// command per core clock. Page p lies in bank p mod banks, and each bank has one page open or none:
///
/// | command       | does                                                                                           |
/// | ------------- | ---------------------------------------------------------------------------------------------- |
/// | activate      | opens a page of a closed bank                                                                  |
/// | read          | puts out words of a bank's open page in the same clock, before its edge: up to words_per_cycle |
/// |               | words, each with its own column, as interleaved memory gives them; with read_latency_cycles so |
/// |               | many clocks later, though a read may follow in each clock                                      |
/// | write         | with shared ports: stores words of write_data_i in a bank's open page, the bytes that the mask |
/// |               | names. Registers at the pins delay them as much as a read's words, so the two never meet there |
/// | precharge     | closes the bank's page                                                                         |
/// | precharge all | closes every bank's page                                                                       |
/// | refresh       | the same, and the memory is busy for refresh_cycles, the command's clock included              |
///
/// With precharge_cycles each bank needs so many clocks from a precharge to an activate, and activate_cycles from an
/// activate to a read or write. A precharge may come in these clocks. Without precharge_cycles only the memory
/// controller counts clocks.
///
/// What takes no clock needs no command: without precharge_cycles an activate closes the page before, and without
/// activate_cycles a read or write opens its page itself, after the clocks of a precharge.
///
/// | /metabuffer/frame_memory/... | is raised for                                                                  |
/// | ---------------------------- | ------------------------------------------------------------------------------ |
/// | page                         | a read or write of a page that is not open, an activate in a bank that is not  |
/// |                              | closed                                                                         |
/// | timing                       | an activate, read or write too soon after the bank's precharge or activate     |
/// | ports                        | a write without shared ports                                                   |
/// | refresh                      | a command in a refresh; a refresh that is overdue, or not needed               |
/// | address                      | a page of another bank, a word that the device does not have                   |
/// | width                        | more words than it has in a clock                                              |
class FrameMemory final : public Block {
  public:
    In<bool> clk_i{"clk_i"};              ///< core clock
    In<bool> reset_i{"reset_i"};          ///< synchronous, active high; what is stored stays
    In<bool> write_clk_i{"write_clk_i"};  ///< DVI input clock
    In<MemoryWrite> write_i{"write_i"};
    In<bool> front_i{"front_i"};  ///< the device that the bus reads; changes while it reads nothing
    In<MemoryCommand> command_i{"command_i"};
    Out<MemoryData> data_o{"data_o"};
    PinVector<In<MemoryData>> write_data_i;  ///< one, only with shared ports

    /// words: pixels of one image.
    FrameMemory(const sc_core::sc_module_name& name, const MemoryConfig& config, std::int64_t words);
    SC_HAS_PROCESS(FrameMemory);

    void trace(sc_core::sc_trace_file* file) const override;

  private:
    struct Bank : MemoryBank {
        Bank(RegisterSet& set, const std::string& name, int page_bits, int most_cycles)
            : MemoryBank(set, name, page_bits) {
            if (most_cycles > 0) wait = std::make_unique<Countdown>(set, name + "_wait", most_cycles);
        }
        std::unique_ptr<Countdown> wait;  ///< clocks that the bank still needs; null if banks are not timed
        bool busy() const { return wait != nullptr && wait->running(); }
        void keep_busy(int clocks) {
            if (wait != nullptr) wait->start(clocks);
        }
    };

    void write_edge();
    void core_edge();
    void reset();
    void obey(const MemoryCommand& command);
    void open(const MemoryCommand& command);
    void watch_refresh(const MemoryCommand& command);
    void refresh(const MemoryCommand& command);
    void close_banks(int clocks);
    void pass_clock();
    void check_timing(const MemoryCommand& command) const;
    void check_activate(const MemoryCommand& command) const;
    void check_words(const MemoryCommand& command) const;
    void store(const MemoryCommand& command);
    void put_out();
    void answer(const MemoryCommand& command, MemoryData& data) const;
    void latency_edge(const MemoryCommand& command);
    std::int64_t address_of(const MemoryCommand& command, std::size_t word) const {
        return std::int64_t{command.row} * config_.page_words + command.columns[word];
    }
    std::int64_t words() const { return static_cast<std::int64_t>(devices_[0].size()); }
    const Bank& bank_of(const MemoryCommand& command) const { return *banks_[command.bank % banks_.size()]; }
    Bank& bank_of(const MemoryCommand& command) { return *banks_[command.bank % banks_.size()]; }
    void refuse(const char* kind, const MemoryCommand& command, const std::string& why) const;

    MemoryConfig config_;
    std::array<std::vector<std::uint64_t>, 2> devices_;  ///< with shared ports all is in the first

    RegisterSet registers_;
    std::vector<std::unique_ptr<Bank>> banks_;
    Countdown refresh_left_;          ///< clocks of a refresh still to pass
    Countdown refresh_due_in_;        ///< clocks until one has to begin; 0 without refreshes
    RegisterLine<MemoryData> reads_;  ///< words on their way out
    MemoryData data_;
    Clocked clocked_{*this, clk_i, reset_i, registers_, &FrameMemory::core_edge, &FrameMemory::reset};
    std::unique_ptr<Clocked> link_clocked_;  ///< null with shared ports
};

}  // namespace metabuffer::rtl
