#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "rtl/block.h"
#include "rtl/countdown.h"
#include "rtl/crossing.h"
#include "rtl/memory_bank.h"
#include "rtl/register.h"
#include "rtl/signals.h"

namespace metabuffer::rtl {

/// Sits between an input framebuffer's bus port and its frame memory (sections 4 and 5.2 of the paper): it turns requests
/// for words into the commands of page-mode memory, refreshes it, and with shared ports writes the link's words. Page p
/// lies in bank p mod banks; the controller knows which page each bank has open.
///
/// Each core clock is used for the first of these that wants it:
///
/// | use      | wants the clock                                  | takes, in clocks                                   |
/// | -------- | ------------------------------------------------ | -------------------------------------------------- |
/// | refresh  | every refresh_interval_cycles from reset on      | refresh_cycles; closes all banks                   |
/// | write    | a full block waits in write_buffer, no page is   | the opening of its page, then one for each         |
/// |          | being opened, and it ends before the next refresh | words_per_cycle words                              |
/// | read     | request_i asks for words                         | the opening of their page, then one                |
/// | close    | request_i wants all banks closed                 | one                                                |
///
/// | opening of a page     | commands              | takes, in clocks                                                  |
/// | --------------------- | --------------------- | ----------------------------------------------------------------- |
/// | its bank is closed    | activate              | page_miss_cycles less precharge_cycles                            |
/// | another page is open  | precharge, activate   | page_miss_cycles; without precharge_cycles no precharge is sent   |
/// | broken off            |                       | by a refresh: all banks are closed. By a request that gives its   |
/// |                       |                       | words up: the bank must be closed, and the page opened anew; but  |
/// |                       |                       | without precharge_cycles the page counts as open                  |
///
/// A read takes as many of the words asked for as lie in the page of the first. answer_o says in the same clock what the
/// clock is used for and how many words are read; it is combinational, as command_o is, from registers and request_i.
/// The memory puts the words out, read_latency_cycles after the command.
class MemoryController final : public Block {
  public:
    In<bool> clk_i{"clk_i"};                   ///< core clock
    In<bool> reset_i{"reset_i"};               ///< synchronous, active high
    In<MemoryRequest> request_i{"request_i"};  ///< stands until its words are read, or are given up
    Out<MemoryAnswer> answer_o{"answer_o"};
    Out<MemoryCommand> command_o{"command_o"};
    // Only with shared ports: the halves of the write buffer.
    PinVector<In<bool>> write_full_i;         ///< DVI input clock: change with each block
    PinVector<In<WriteBlock>> write_block_i;  ///< stable after that change
    PinVector<Out<bool>> drain_o;             ///< one: the half that is written

    /// image_words: pixels of one image.
    MemoryController(const sc_core::sc_module_name& name, const MemoryConfig& config,
                     std::int64_t image_words);

    void trace(sc_core::sc_trace_file* file) const override;

  private:
    struct Bank : MemoryBank {
        Bank(RegisterSet& set, const std::string& name, int page_bits)
            : MemoryBank(set, name, page_bits), half_open(set, name + "_half_open") {}
        Register<bool> half_open;  ///< an opening was broken off: closed before a page is opened again

        void open(std::uint32_t page) {
            MemoryBank::open(page);
            half_open = false;
        }
        void close() {
            MemoryBank::close();
            half_open = false;
        }
    };

    /// With shared ports: the block of the link's words that is being written, or is next.
    struct Writes {
        Writes(RegisterSet& set, const MemoryConfig& memory);
        struct Half {
            Half(RegisterSet& set, std::size_t number);
            Crossing full;
            Register<bool> waiting;  ///< its block is to be written
        };
        std::vector<std::unique_ptr<Half>> halves;
        Register<bool> drain;      ///< the half whose turn it is
        Register<int> words_left;  ///< of the block that is being written; 0: none

        std::size_t turn() const { return drain ? 1 : 0; }
        Half& half() const { return *halves[turn()]; }
    };

    /// What it takes to open a page.
    struct Opening {
        std::uint32_t page = 0;
        bool opens = false;   ///< the page is not open
        bool closes = false;  ///< its bank must be closed before
        int cycles = 0;
    };

    /// What the clock before the next edge is used for.
    struct Plan {
        MemoryAnswer::Kind use = MemoryAnswer::Kind::kNone;
        bool gives_up = false;  ///< the page that is being opened is not wanted any more
        Opening opening;        ///< where it begins in this clock, or the page is open
        MemoryCommand command;
    };

    void clock_edge();
    void reset();
    void sample_writes();
    void open_page();
    void count_written();
    void count_refresh();
    void close_banks();

    void answer();
    Plan plan() const;
    bool plan_opening(Plan& plan, std::uint32_t page) const;
    void plan_read(Plan& plan) const;
    void plan_write(Plan& plan) const;
    bool write_begins(bool gives_up) const;
    bool write_under_way() const { return writes_ != nullptr && writes_->words_left > 0; }
    bool refresh_begins() const { return config_.refreshes() && !refresh_due_in_.running(); }
    Opening opening_of(std::uint32_t page, bool gives_up) const;
    MemoryCommand command_for(MemoryCommand::Kind kind, std::uint32_t page) const;
    const WriteBlock& block() const { return write_block_i[writes_->turn()].read(); }
    std::uint32_t page_of(std::uint64_t address) const {
        return static_cast<std::uint32_t>(address / static_cast<std::uint64_t>(config_.page_words));
    }
    std::uint32_t column_of(std::uint64_t address) const {
        return static_cast<std::uint32_t>(address % static_cast<std::uint64_t>(config_.page_words));
    }
    Bank& bank_of(std::uint32_t page) const { return *banks_[page % banks_.size()]; }

    MemoryConfig config_;
    int address_bits_;

    RegisterSet registers_;
    Countdown page_wait_;                                    ///< until the page that is being opened is open
    Register<std::uint32_t> opening_;                        ///< that page
    Register<bool> precharging_{registers_, "precharging"};  ///< its activate comes after a precharge
    Countdown refresh_due_in_;                               ///< until the next refresh begins
    Countdown refresh_left_;
    std::vector<std::unique_ptr<Bank>> banks_;  ///< as they are once the memory has obeyed
    std::unique_ptr<Writes> writes_;            ///< null without shared ports

    Plan plan_;  ///< combinational
    Clocked clocked_{
        *this, clk_i, reset_i, registers_, &MemoryController::clock_edge, &MemoryController::reset};
};

}  // namespace metabuffer::rtl
