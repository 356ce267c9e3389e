#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "datapath/segment.h"
#include "report/report.h"
#include "rtl/block.h"
#include "rtl/register.h"
#include "rtl/signals.h"

namespace metabuffer::rtl {

/// An input framebuffer's port to its renderer's bus (sections 5 and 5.3 of the paper). It asks the link's side for the
/// pair of each frame, broadcasts the pair's table, and sends its segments burst by burst, as the arbiter grants them.
///
/// Timing, in core clocks, with at most one beat per clock:
/// - every beat names its frame and its position among the rows or pixels.
/// - table: the port polls until every composer's TABLEREADY is high. Then it sends one frame-start beat, and each row
///   in 128 / width_bits clocks (at least one).
/// - bursts: while no burst is under way the arbiter's answer is taken. A grant's first beat goes out in the same
///   clock, unless its page must be opened first. Beats follow each other without a gap on an open page. A beat never
///   crosses a page.
/// - refresh: the memory is refreshed every refresh_interval_cycles, counted from the end of reset, whatever else
///   happens. The beat under way continues, since the memory has given its words. The opening of a page is broken off,
///   all banks are closed, and the next word's page is opened after the refresh.
/// - shared ports: a full block of the link's words in write_buffer is written as soon as no page is being opened, no
///   refresh is under way and the block can be finished before the next refresh, whatever else happens. It takes the
///   clocks that open its page, then one for each words_per_cycle words. The beat under way continues, and the next
///   word waits. The block's page stays open in its bank. Pages stay open from frame to frame, too, since there is one
///   device.
/// - read latency: a read may still follow a read in the next clock. Every beat, a table's too, goes out
///   read_latency_cycles after the decision that sent it, so that their order stays.
/// - BUSREADY is read one clock after its composer wrote it. In a burst, a low one stops the burst before the clock's
///   beat, and the arbiter is asked in that same clock. If a page is being opened then, its bank must be closed and
///   the page opened anew, unless precharge_cycles is 0: then the page counts as open. With read latency and bus
///   registers, BUSREADY answers an earlier beat, sent as many clocks before as a beat and its answer take, and it is
///   judged by that beat. A composer is passed over while its BUSREADY cannot count yet what it was sent last: the only
///   beat of a burst, one that moved when its burst was stopped, or on such a bus the last beat of any burst. Likewise
///   a frame's start waits until TABLEREADY counts the frame before.
///
/// What the port asks of arbiter and memory in a clock (ready_o, take_o, command_o) is combinational, from its
/// registers, BUSREADY and the grant; it samples their answers at the clock's edge. Everything else is registered.
class BusPort final : public Block {
  public:
    /// kRequest: asks for a pair; kWait: waits for it; kTable: broadcasts its table; kSend: sends bursts; kDone: every
    /// frame has been sent.
    enum class State : std::uint8_t { kRequest, kWait, kTable, kSend, kDone };

    sc_core::sc_in<bool> clk_i{"clk_i"};      ///< core clock
    sc_core::sc_in<bool> reset_i{"reset_i"};  ///< synchronous, active high
    // The link's side.
    sc_core::sc_out<bool> request_o{"request_o"};   ///< changes when the next frame's pair is wanted
    sc_core::sc_in<bool> answer_i{"answer_i"};      ///< DVI input clock: changes with each answer
    sc_core::sc_in<bool> fresh_i{"fresh_i"};        ///< changes only with an answer
    sc_core::sc_in<FrontTable> table_i{"table_i"};  ///< likewise
    // Only with shared ports: which image of the memory is read, and the halves of the write buffer.
    sc_core::sc_vector<sc_core::sc_in<bool>> front_i;       ///< one; changes only with an answer
    sc_core::sc_vector<sc_core::sc_in<bool>> write_full_i;  ///< DVI input clock: change with each block
    sc_core::sc_vector<sc_core::sc_in<WriteBlock>> write_block_i;  ///< stable after that change
    sc_core::sc_vector<sc_core::sc_out<bool>> drain_o;             ///< one: the half that is written
    // The bus.
    sc_core::sc_out<BusBeat> bus_o{"bus_o"};
    sc_core::sc_vector<sc_core::sc_in<bool>> busready_i;  ///< one per composer of the row
    sc_core::sc_vector<sc_core::sc_in<bool>> tableready_i;
    // The arbiter: a line of each kind for each row of the table.
    sc_core::sc_out<bool> start_o{"start_o"};
    sc_core::sc_out<bool> take_o{"take_o"};
    sc_core::sc_vector<sc_core::sc_out<bool>> pending_o;
    sc_core::sc_vector<sc_core::sc_out<bool>> ready_o;
    sc_core::sc_vector<sc_core::sc_out<std::uint64_t>> deadline_o;  ///< only under a policy that uses it
    sc_core::sc_vector<sc_core::sc_in<bool>> grant_i;
    sc_core::sc_in<bool> grant_valid_i{"grant_valid_i"};
    sc_core::sc_in<bool> search_i{"search_i"};  ///< an answer is on its way
    sc_core::sc_in<bool> lost_i{"lost_i"};
    sc_core::sc_in<std::uint16_t> recovered_i{"recovered_i"};
    // The memory.
    sc_core::sc_out<MemoryCommand> command_o{"command_o"};
    sc_core::sc_in<MemoryData> data_i{"data_i"};

    /// The scenario must outlive the module. on_start is called at each frame's start; bus counts what the bus does.
    BusPort(const sc_core::sc_module_name& name, const Scenario& scenario, const Renderer& renderer,
            std::function<void(bool fresh)> on_start, BusCounters& bus);
    SC_HAS_PROCESS(BusPort);

    void trace(sc_core::sc_trace_file* file) const override;
    std::string waiting_for() const override;

    /// Adds clocks that have passed without having been counted yet: a port that waits for a pair or a slot sleeps.
    void count_slept_cycles(BusCounters& bus) const { bus.*counted_ += clocked_.edges_asleep(); }

  private:
    /// Where the next pixel of a table row is in memory.
    struct Row {
        Row(RegisterSet& set, const std::string& name, const Renderer& renderer, std::int64_t memory_words);
        Segment segment;              ///< of the table, which does not change
        Register<std::int64_t> left;  ///< pixels not put into a beat yet
        Register<std::int64_t> address;
        Register<int> column;

        std::size_t composer() const { return segment.row().dcomp - std::size_t{1}; }
    };

    /// What the memory's bank has open once it has obeyed.
    struct Bank {
        Bank(RegisterSet& set, const std::string& name, int page_bits)
            : open(set, name + "_open"),
              half_open(set, name + "_half_open"),
              page(set, name + "_page", page_bits) {}
        Register<bool> open;
        Register<bool>
            half_open;  ///< an opening was broken off: the bank must be closed before a page is opened again
        Register<std::int64_t> page;
    };

    /// With shared ports: the block of the link's words that is being written, or is next.
    struct Writes {
        Writes(RegisterSet& set, const MemoryConfig& memory);
        struct Half {
            Half(RegisterSet& set, std::size_t number);
            Synchronizer full;
            Register<bool> seen;     ///< last level of `full`
            Register<bool> waiting;  ///< its block is to be written
        };
        std::vector<std::unique_ptr<Half>> halves;
        Register<bool> drain;      ///< the half whose turn it is
        Register<int> words_left;  ///< of the block that is being written; 0: none
        Register<int> page_wait;   ///< clocks until its page is open
        Register<bool> precharging;

        std::size_t turn() const { return drain ? 1 : 0; }
        Half& half() { return *halves[turn()]; }
        const Half& half() const { return *halves[turn()]; }
        bool any() const { return words_left > 0 || half().waiting; }
    };

    /// What it takes to open a page.
    struct Opening {
        bool opens = false;   ///< the page is not open
        bool closes = false;  ///< its bank must be closed before
        int cycles = 0;
    };

    /// What the clock before the next edge is used for, as far as registers, BUSREADY and the grant decide it.
    struct Plan {
        bool stop = false;       ///< the burst under way ends here
        bool arbitrate = false;  ///< the arbiter's answer is taken
        int row = kNoRow;        ///< whose burst it is then; kNoRow: none
        Opening opening;         ///< of its next word's page
        bool refreshes = false;  ///< the memory is busy with a refresh
        bool writes = false;     ///< the memory is busy with the link's words
        // With kRead: the row's position after the words that are read.
        MemoryCommand command;
        std::int64_t next_address = 0;
        int next_column = 0;
    };

    static constexpr int kNoRow = -1;

    void clock_edge();
    void reset();
    void count_sleep() { bus_.*counted_ += clocked_.slept_edges(); }
    /// Each clock is counted once, by what it was used for.
    void count(std::int64_t BusCounters::*counter) {
        counted_ = counter;
        ++(bus_.*counter);
    }
    void ask_for_frame();
    void start_frame(bool fresh);
    void table_clock();
    void send_clock();
    void count_answers();
    bool composers_take_table() const;
    bool take_grant();
    void stop_burst();
    void refresh_clock();
    void close_banks();
    void note_open(std::int64_t page);
    void sample_writes();
    void write_clock();
    bool page_ready(const Plan& plan);
    void fill_beat(const Plan& plan);
    void drive_beat();
    void put_out();
    void pass_over(std::size_t composer, int clocks);

    void drive_requests();
    void drive_ready();
    void drive_deadline(std::size_t row);
    Plan plan() const;
    void plan_memory(Plan& plan) const;
    bool plan_writes(const Plan& plan) const;
    void plan_write_command(Plan& plan) const;
    Opening opening_of(std::int64_t page, bool stop) const;
    MemoryCommand opening_command(const Opening& opening, std::int64_t page) const;
    std::int64_t write_page() const {
        return static_cast<std::int64_t>(write_block_i[writes_->turn()].read().address) /
               scenario_.memory.page_words;
    }
    std::int64_t page_of(const Row& of_row) const { return of_row.address / scenario_.memory.page_words; }
    const Bank& bank_of(std::int64_t page) const {
        return *banks_[static_cast<std::size_t>(page) % banks_.size()];
    }
    Bank& bank_of(std::int64_t page) { return *banks_[static_cast<std::size_t>(page) % banks_.size()]; }
    MemoryCommand command_for(MemoryCommand::Kind kind, std::int64_t page) const;
    bool burst_is_stopped() const;
    /// If the burst is stopped now, its bank is left in the middle of an opening.
    bool breaks_opening_off() const { return page_wait_ > 0 && scenario_.memory.times_banks(); }
    bool refresh_begins() const { return scenario_.memory.refreshes() && refresh_due_in_ == 0; }
    int granted_row() const;
    /// The number that the beats of the frame under way name.
    std::uint32_t frame_on_bus() const { return static_cast<std::uint32_t>(frames_started_ - 1); }
    Row& row(int index) { return *rows_[static_cast<std::size_t>(index)]; }
    const Row& row(int index) const { return *rows_[static_cast<std::size_t>(index)]; }

    const Scenario& scenario_;
    const Renderer& renderer_;
    std::function<void(bool)> on_start_;
    BusCounters& bus_;
    int pixels_per_beat_;
    int cycles_per_beat_;
    int cycles_per_table_row_;
    int lost_slot_cycles_;
    int raster_width_pixels_;
    int raster_height_pixels_;
    Smoothing smoothing_;
    int loop_cycles_;  ///< that read latency and registers add until a beat's answer is read

    std::int64_t BusCounters::*counted_ = &BusCounters::idle_cycles;  ///< the counter of the last clock

    RegisterSet registers_;
    Register<State> state_{registers_, "state", 3};
    Register<bool> request_{registers_, "request"};
    Synchronizer answer_{registers_, "answer"};
    Register<bool> answer_seen_{registers_, "answer_seen"};
    Register<int> frames_started_;
    Register<std::int64_t> pixels_left_;  ///< of the frame
    Register<int> row_count_;             ///< of the frame's table
    Register<int> table_row_;             ///< next to broadcast
    Register<int> table_wait_;
    Register<bool> table_started_{registers_, "table_started"};
    Register<bool> bursting_{registers_, "bursting"};  ///< a burst is under way
    Register<int> burst_row_;                          ///< its row in the table
    Register<int> burst_left_;                         ///< pixels of it that have not been put into a beat
    Register<bool> burst_started_{registers_, "burst_started"};  ///< a beat of it has gone out
    Register<bool> closing_{registers_, "closing"};              ///< a frame is over: its pages are closed
    Register<bool> precharging_{registers_,
                                "precharging"};  ///< the page waited for is opened after a precharge
    Register<int> page_wait_;
    Register<int> beat_wait_;           ///< clocks of a beat on a narrow bus still to pass
    Register<int> lost_wait_;           ///< clocks of a lost slot still to pass
    Register<int> announced_;           ///< pixels of the burst after the last beat driven
    Register<int> announced_before_;    ///< the same when the composer wrote the BUSREADY that is read next
    RegisterLine<int> announced_line_;  ///< the same in the clocks between
    Register<int> uncounted_cycles_;    ///< clocks until every BUSREADY counts what its composer was sent
    Register<int> table_uncounted_cycles_;  ///< clocks until TABLEREADY counts the newest frame's start
    Register<bool> stopped_{registers_, "stopped"};  ///< the burst was stopped while its last beat was moving
    Register<int> refresh_due_in_;                   ///< clocks until the next refresh begins
    Register<int> refresh_left_;                     ///< clocks of a refresh still to pass
    Register<BusBeat> beat_{registers_, "beat", 0};  ///< without its words
    Register<MemoryData> words_;                     ///< the last that have come
    RegisterLine<BusBeat> leaving_;                  ///< beats that wait for their words
    std::vector<std::unique_ptr<Register<int>>>
        uncounted_;  ///< by composer: clocks for which it is passed over
    std::vector<std::unique_ptr<Bank>> banks_;
    std::vector<std::unique_ptr<Row>> rows_;  ///< as many as a table may have; row_count_ are used

    std::unique_ptr<Writes> writes_;  ///< null without shared ports

    Plan plan_;          ///< combinational
    bool asked_ = true;  ///< its combinational outputs may be active
    bool bus_driven_ = false;
    BusBeat sent_;  ///< the beat sent by this clock, without its words
    Clocked clocked_{*this, clk_i, reset_i, registers_, &BusPort::clock_edge, &BusPort::reset};
};

}  // namespace metabuffer::rtl
