#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "datapath/segment.h"
#include "report/machine_event.h"
#include "report/report.h"
#include "rtl/block.h"
#include "rtl/countdown.h"
#include "rtl/crossing.h"
#include "rtl/register.h"
#include "rtl/signals.h"

namespace metabuffer::rtl {

/// An input framebuffer's port to its renderer's bus (sections 5 and 5.3 of the paper). It asks the link's side for the
/// pair of each frame, broadcasts the pair's table, and sends its segments burst by burst, as the arbiter grants them and
/// the memory controller gives their words.
///
/// | what          | core clocks                                                                                   |
/// | ------------- | --------------------------------------------------------------------------------------------- |
/// | table         | starts when every TABLEREADY is high: one frame-start beat, then each row in 128 / width_bits |
/// |               | clocks, at least one                                                                          |
/// | burst         | while none is under way the arbiter's answer is taken in each clock; a grant's first words    |
/// |               | are asked for in the same clock                                                               |
/// | beat          | goes out in the clock that reads its words, on a narrow bus 64 / width_bits - 1 clocks later; |
/// |               | it never crosses a page                                                                       |
/// | read latency  | delays every beat, a table's too, so that their order stays                                   |
/// | BUSREADY low  | stops the burst before the clock's beat, and the arbiter is asked in that same clock          |
///
/// Every beat names its frame and its position among the rows or pixels.
///
/// BUSREADY and TABLEREADY are old when they are read: by a clock, and with read latency and bus registers by the clocks
/// that a beat and its answer take, too. A low BUSREADY is judged by the beat that it answers: it stops a burst only if
/// more than one beat was announced to follow that one. And a composer gets no grant while its BUSREADY is older than the
/// beat that was last sent to it with nothing to follow: the only beat of a burst, one that was moving when its burst was
/// stopped, or on a bus with read latency or registers the last beat of any burst. Likewise a frame's start waits for a
/// TABLEREADY that is newer than the frame start before.
///
/// What the port asks of arbiter and memory in a clock (ready_o, take_o, memory_o) is combinational, from its registers,
/// BUSREADY and the grant; it samples their answers at the clock's edge. Everything else is registered.
class BusPort final : public Block {
  public:
    /// kRequest: asks for a pair; kWait: waits for it; kTable: broadcasts its table; kSend: sends bursts; kDone: every
    /// frame has been sent.
    enum class State : std::uint8_t { kRequest, kWait, kTable, kSend, kDone };

    In<bool> clk_i{"clk_i"};      ///< core clock
    In<bool> reset_i{"reset_i"};  ///< synchronous, active high
    // The link's side.
    Out<bool> request_o{"request_o"};   ///< changes when the next frame's pair is wanted
    In<bool> answer_i{"answer_i"};      ///< DVI input clock: changes with each answer
    In<bool> fresh_i{"fresh_i"};        ///< changes only with an answer
    In<FrontTable> table_i{"table_i"};  ///< likewise
    PinVector<In<bool>> front_i;        ///< one, only with shared ports: which image is read; likewise
    // The bus.
    Out<BusBeat> bus_o{"bus_o"};
    PinVector<In<bool>> busready_i;  ///< one per composer of the row
    PinVector<In<bool>> tableready_i;
    // The arbiter: a line of each kind for each row of the table.
    Out<bool> start_o{"start_o"};
    Out<bool> take_o{"take_o"};
    PinVector<Out<bool>> pending_o;
    PinVector<Out<bool>> ready_o;
    PinVector<Out<std::uint64_t>> deadline_o;  ///< only under a policy that uses it
    PinVector<In<bool>> grant_i;
    In<bool> grant_valid_i{"grant_valid_i"};
    In<bool> search_i{"search_i"};  ///< an answer is on its way
    In<bool> lost_i{"lost_i"};
    In<std::uint16_t> recovered_i{"recovered_i"};
    // The memory.
    Out<MemoryRequest> memory_o{"memory_o"};
    In<MemoryAnswer> memory_i{"memory_i"};
    In<MemoryData> data_i{"data_i"};

    /// The scenario must outlive the module. on_start is called at each frame's start; bus counts what the bus does.
    BusPort(const sc_core::sc_module_name& name, const Scenario& scenario, const Renderer& renderer,
            std::function<void(bool fresh)> on_start, BusCounters& bus);

    void trace(sc_core::sc_trace_file* file) const override;
    std::string waiting_for() const override;

    /// The first grant for which the arbiter has passed over slots, and the display of the composer that got the bus; the
    /// port does not know its renderer.
    const MachineEvent& first_recovered_slot() const { return first_recovered_slot_; }

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
        int image_width_pixels;

        std::size_t composer() const { return segment.row().dcomp - std::size_t{1}; }
        /// Of the pixel that many after the next one.
        std::int64_t address_of(int pixels) const {
            const int width = segment.row().sdx;
            return address + pixels + std::int64_t{(column + pixels) / width} * (image_width_pixels - width);
        }
        /// So many have been put into a beat.
        void advance(int pixels);
    };

    /// What the clock before the next edge is used for, as far as registers, BUSREADY and the grant decide it.
    struct Plan {
        bool stop = false;       ///< the burst under way ends here
        bool arbitrate = false;  ///< the arbiter's answer is taken
        int row = kNoRow;        ///< whose burst it is then; kNoRow: none
        MemoryRequest request;
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
    void fill_beat(int pixels);
    void drive_beat();
    void put_out();
    void pass_over(std::size_t composer, int clocks);

    void drive_requests();
    void drive_ready();
    void drive_deadline(std::size_t row);
    Plan plan() const;
    void ask_for_words(Plan& plan) const;
    bool burst_is_stopped() const;
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

    MachineEvent first_recovered_slot_;
    std::int64_t BusCounters::*counted_ = &BusCounters::idle_cycles;  ///< the counter of the last clock

    RegisterSet registers_;
    Register<State> state_{registers_, "state", 3};
    Register<bool> request_{registers_, "request"};
    Crossing answer_{registers_, "answer"};
    Register<int> frames_started_;
    Register<std::int64_t> pixels_left_;  ///< of the frame
    Register<int> row_count_;             ///< of the frame's table
    Register<int> table_row_;             ///< next to broadcast
    Countdown table_wait_;
    Register<bool> table_started_{registers_, "table_started"};
    Register<bool> bursting_{registers_, "bursting"};  ///< a burst is under way
    Register<int> burst_row_;                          ///< its row in the table
    Register<int> burst_left_;                         ///< pixels of it that have not been put into a beat
    Register<bool> burst_started_{registers_, "burst_started"};  ///< a beat of it has gone out
    Register<bool> closing_{registers_, "closing"};              ///< a frame is over: its pages are closed
    Countdown beat_wait_;               ///< clocks of a beat on a narrow bus still to pass
    Countdown lost_wait_;               ///< clocks of a lost slot still to pass
    Register<int> announced_;           ///< pixels of the burst after the last beat driven
    Register<int> announced_before_;    ///< the same when the composer wrote the BUSREADY that is read next
    RegisterLine<int> announced_line_;  ///< the same in the clocks between
    Countdown uncounted_cycles_;        ///< until every BUSREADY is new enough
    Countdown table_uncounted_cycles_;  ///< until TABLEREADY is new enough
    Register<bool> stopped_{registers_, "stopped"};  ///< the burst was stopped while its last beat was moving
    Register<BusBeat> beat_{registers_, "beat", 0};  ///< without its words
    Register<MemoryData> words_;                     ///< the last that have come
    RegisterLine<BusBeat> leaving_;                  ///< beats that wait for their words
    std::vector<std::unique_ptr<Countdown>> uncounted_;  ///< by composer: until its BUSREADY is new enough
    std::vector<std::unique_ptr<Row>> rows_;             ///< as many as a table may have; row_count_ are used

    Plan plan_;          ///< combinational
    bool asked_ = true;  ///< its combinational outputs may be active
    bool bus_driven_ = false;
    BusBeat sent_;  ///< the beat sent by this clock, without its words
    Clocked clocked_{*this, clk_i, reset_i, registers_, &BusPort::clock_edge, &BusPort::reset};
};

}  // namespace metabuffer::rtl
