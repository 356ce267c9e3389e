#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "datapath/link/bank_keeper.h"
#include "datapath/segment.h"
#include "report/machine_report.h"
#include "rtl/block.h"
#include "rtl/bus_arbiter.h"
#include "rtl/frame_memory.h"
#include "rtl/signals.h"

namespace metabuffer::rtl {

/// The input framebuffer, box B of the paper's Figure 1 (sections 4 and 5): takes a renderer's pairs into the
/// back bank of its memory and sends the front one's segments over the renderer's bus.
///
/// The link's side keeps the banks (BankKeeper). For each frame the bus side asks it for a pair; it answers "fresh"
/// after swapping the banks, or "again" if the front pair is to be repeated. Both words cross the clock domains
/// through two registers.
///
/// The bus side, in core clocks, one beat a clock at most:
/// - every beat is marked with its frame and with its place among the rows or pixels.
/// - table: one frame-start beat, then each row in 128 / width_bits clocks (at least one), once every
///   composer's TABLEREADY is high; until then it polls.
/// - bursts: with no burst under way the arbiter is asked; a grant's first beat goes out in the same clock,
///   unless its page must be opened first, and beats follow each other without a gap on an open page. A beat
///   never crosses a page.
/// - BUSREADY is read one clock after its composer wrote it. In a burst, a low one stops it before the
///   clock's beat, and the arbiter is asked in that same clock. A composer whose BUSREADY cannot count the last beat
///   yet (a burst of one beat in the clock before, or one stopped while a beat was moving) is passed over.
class InputFramebuffer final : public Block {
  public:
    sc_core::sc_in<bool> clk_i{"clk_i"};          ///< core clock
    sc_core::sc_in<bool> reset_i{"reset_i"};      ///< synchronous in both domains, active high
    sc_core::sc_in<bool> dvi_clk_i{"dvi_clk_i"};  ///< DVI input clock
    sc_core::sc_in<DecodedPixel> pixel_i{"pixel_i"};
    sc_core::sc_in<DecoderEvent> event_i{"event_i"};
    sc_core::sc_out<bool> pair_request_o{"pair_request_o"};  ///< the back bank is free (DVI input clock)
    sc_core::sc_vector<sc_core::sc_in<bool>> busready_i;     ///< one a composer of the row
    sc_core::sc_vector<sc_core::sc_in<bool>> tableready_i;
    sc_core::sc_out<BusBeat> bus_o{"bus_o"};

    /// renderer: index, from 0. The scenario must outlive the module.
    InputFramebuffer(const sc_core::sc_module_name& name, const Scenario& scenario, int renderer);
    SC_HAS_PROCESS(InputFramebuffer);

    void trace(sc_core::sc_trace_file* file) const override;
    std::string waiting_for() const override;

    /// Counters of bus and table; what the link rejected is the decoder's.
    const RendererCounters& counters() const { return renderer_counters_; }

    /// What each composited frame that has been started was made of.
    const std::vector<FrameSource>& frame_sources() const { return frame_sources_; }

    /// Pixels taken from the link, for the watchdog.
    std::int64_t link_pixels() const { return link_pixels_; }

  private:
    // ---- the link's side (DVI input clock) ----
    struct Answer {
        bool toggle = false;
        bool fresh = false;
        friend bool operator==(const Answer& a, const Answer& b) {
            return a.toggle == b.toggle && a.fresh == b.fresh;
        }
        friend std::ostream& operator<<(std::ostream& out, const Answer& answer) {
            return out << (answer.fresh ? "fresh" : "again");
        }
        friend void sc_trace(sc_core::sc_trace_file* file, const Answer& answer, const std::string& name) {
            sc_core::sc_trace(file, answer.toggle, name + ".toggle");
            sc_core::sc_trace(file, answer.fresh, name + ".fresh");
        }
    };

    void link_clock_edge();
    void run_link();
    void link_reset();
    void take_event(const DecoderEvent& event);
    void swap_banks();

    // ---- the bus side (core clock) ----
    enum class State : std::uint8_t { kRequest, kWait, kTable, kSend, kDone };

    static constexpr int kNoRow = -1;

    /// A row of the frame under way and where its next pixel stands in memory.
    struct Row {
        Segment segment;
        std::size_t composer = 0;
        std::int64_t left = 0;  ///< pixels not put into a beat yet
        std::int64_t address = 0;
        int column = 0;
    };

    void clock_edge();
    void reset();
    void ask_for_frame();
    void start_frame(bool fresh);
    /// What the beats of the frame under way are marked with.
    std::uint32_t frame_on_bus() const { return static_cast<std::uint32_t>(frames_started_ - 1); }
    void table_clock();
    bool composers_take_table() const;
    void send_clock();
    bool arbitrate(int passed_over_row);
    void stop_burst_on_busready();
    bool page_ready(std::int64_t address);
    void fill_beat(Row& row);
    void drive_beat();
    void drive(const BusBeat& beat);
    void drive_nothing();

    const Scenario& scenario_;
    const Renderer& renderer_;
    ViewportLimits limits_;
    int pixels_per_beat_;
    int cycles_per_beat_;
    int cycles_per_table_row_;
    int lost_slot_cycles_;

    FrameMemory frame_memory_;
    BusArbiter bus_arbiter_;

    sc_core::sc_signal<bool> request_{"request"};  ///< toggles when the bus side wants the next frame
    sc_core::sc_signal<Answer> answer_{"answer"};

    // The link's registers.
    BankKeeper banks_;
    ViewportTable back_table_;  ///< as it comes; once the pair is whole, its valid rows
    std::uint32_t back_number_ = 0;
    std::int64_t link_edge_ = 0;  ///< number of the link clock's edge
    std::int64_t previous_edge_picoseconds_ = 0;
    std::int64_t last_pixel_picoseconds_ = 0;  ///< when the last pixel was on the link
    std::int64_t link_pixels_ = 0;
    bool request_seen_ = false;
    bool pair_request_ = false;
    Answer answer_now_;
    Synchronizer<bool> request_synchronizer_;
    // Written at the swap, read by the bus side after the answer has crossed.
    ViewportTable front_rows_;
    FrameSource front_source_;

    // The bus side's registers.
    State state_ = State::kRequest;
    Synchronizer<Answer> answer_synchronizer_;
    bool answer_toggle_ = false;
    int frames_started_ = 0;
    std::vector<Row> rows_;             ///< of the frame that is sent
    std::vector<BusRequest> requests_;  ///< one a row
    std::int64_t pixels_left_ = 0;      ///< of the frame
    std::size_t table_row_ = 0;         ///< next to broadcast
    int table_wait_ = 0;
    bool table_started_ = false;
    int burst_row_ = kNoRow;      ///< whose burst is under way
    int burst_left_ = 0;          ///< pixels of it that have not been put into a beat
    bool burst_started_ = false;  ///< a beat of it has gone out
    int page_wait_ = 0;
    int beat_wait_ = 0;         ///< clocks of a beat on a narrow bus still to pass
    int lost_wait_ = 0;         ///< clocks of a lost slot still to pass
    int announced_ = 0;         ///< pixels of the burst behind the last beat driven
    int announced_before_ = 0;  ///< the same one clock ago
    int announced_seen_ = 0;    ///< the same when the composer wrote the BUSREADY that is read now
    int unseen_row_ = kNoRow;   ///< row sent a beat that the BUSREADY read now does not count
    int stopped_row_ = kNoRow;  ///< row whose burst was stopped while its last beat was moving
    bool bus_driven_ = false;
    BusBeat beat_;

    RendererCounters renderer_counters_;
    std::vector<FrameSource> frame_sources_;
};

}  // namespace metabuffer::rtl
