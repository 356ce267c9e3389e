#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <memory>
#include <string>
#include <systemc>
#include <vector>

#include "datapath/arbitration/arbitration_policy.h"
#include "datapath/link/pair_keeper.h"
#include "datapath/segment.h"
#include "report/machine_event.h"
#include "report/machine_report.h"
#include "scenario/scenario.h"
#include "tlm/agenda.h"
#include "tlm/bus_record.h"
#include "tlm/content_cache.h"
#include "tlm/cycle.h"
#include "tlm/payload.h"
#include "tlm/schedule_observer.h"

namespace metabuffer::tlm {

/// The input framebuffer, box B of the paper's Figure 1 (sections 4 and 5): keeps a renderer's pairs in two
/// banks and sends the front one's segments over the bus, burst by burst. Rules and clocks are those of level
/// rtl (docs/design.md).
///
/// The link's side acts at the DVI input clocks in which the decoder reports something, a request arrives or a timeout
/// ends. The bus side takes each decision at its core clock: the frame-start beat, an arbitration, and within a burst
/// what the memory or BUSREADY may still change. What is certain from then on, the beats of a burst above all, follows
/// in one transaction.
class InputFramebuffer final : public sc_core::sc_module {
  public:
    TargetSocket<InputFramebuffer, DecodedFrame> link_socket{"link_socket"};
    sc_core::sc_out<bool> pair_request_o{"pair_request_o"};  ///< DVI input clock
    InitiatorSocket<InputFramebuffer, MemoryAccess> memory_socket{"memory_socket"};
    InitiatorSocket<InputFramebuffer, BusTransfer> bus_socket{"bus_socket"};  ///< BusTransfer, BusNotice

    struct Settings {
        int renderer = 0;                  ///< index, from 0
        std::int64_t first_link_edge = 0;  ///< first DVI input clock without reset
        std::int64_t first_cycle = 0;      ///< first core clock without reset
        ContentCache* cache = nullptr;     ///< null: no images
        ScheduleObserver* observer = nullptr;
    };
    /// Scenario and agenda must outlive the module.
    InputFramebuffer(const sc_core::sc_module_name& name, const Scenario& scenario, Agenda& agenda,
                     const Settings& settings);
    SC_HAS_PROCESS(InputFramebuffer);

    /// What each composited frame that has been started was made of.
    const std::vector<FrameSource>& frame_sources() const { return frame_sources_; }

    /// The first grant for which the arbiter has passed over slots, and the display of the composer that got the bus. It
    /// may lie ahead of the present clock; its renderer is not set.
    const MachineEvent& first_recovered_slot() const { return first_recovered_slot_; }

    /// Everything counted up to a core clock, which must be the present one; `core_cycles` of the run are one more.
    RendererCounters counters(std::int64_t through_cycle) const;
    /// What the watchdog checks: pixels and table clocks on the bus up to a core clock; pixels received from the link
    /// up to a DVI input clock.
    std::int64_t bus_progress(std::int64_t through_cycle) const;
    std::int64_t link_pixels(std::int64_t through_edge) const;
    std::string waiting_for(std::int64_t through_cycle) const;

  private:
    // ---- the link's side (DVI input clock) ----
    void take_frame(Payload& payload, sc_core::sc_time& delay);
    void report_link_frame(const DecodedFrame& frame) const;
    void link_process();
    void take_event(const LinkEvent& event, std::int64_t edge);
    void answer(bool fresh, std::int64_t edge);
    void wake_link();

    // ---- the bus side (core clock) ----
    enum class State : std::uint8_t {
        kSend,   ///< arbitrates, or asks the link's side for a pair once all has been sent
        kWait,   ///< waits for its answer
        kStart,  ///< reads the answer
        kTable,  ///< broadcasts the table, once every composer can receive it
        kBurst,  ///< in a burst
        kDone,
    };
    struct Row {
        Segment segment;
        std::int64_t left = segment.pixels();  ///< pixels to be sent
        std::int64_t sent = 0;
        std::int64_t address = 0;  ///< of the next pixel, in words of the memory
        int column = 0;            ///< of the next pixel
        SlotTime slot{};

        int display() const { return segment.row().dcomp; }
    };
    struct TableReady {
        int frame = -1;
        int composers = 0;
        std::int64_t cycle = 0;
    };

    Decision decide(std::int64_t cycle);
    bool is_certain() const;
    int frame() const { return frames_started_ - 1; }  ///< the newest one
    void ask_for_frame(std::int64_t cycle);
    void start_frame(std::int64_t cycle);
    std::int64_t table_cycle() const;
    void send_table(std::int64_t cycle);
    void arbitrate(std::int64_t cycle);
    void start_burst(int row, int recovered_slots);
    void continue_burst();
    void access_memory(const Row& row);
    void break_off_opening(std::int64_t cycle);
    void wait_for_memory(const MemoryAccess& access, std::int64_t clocks);
    int pixels_before(std::int64_t cycle, int pixels) const;
    void send_beats(int pixels);
    std::int64_t judge_beats();
    void go_on_at(std::int64_t cycle);
    void end_burst(bool whole);
    void advance(Row& row, int pixels) const;
    void ask_for_slot(Row& row, std::int64_t earliest);
    BusTransfer& transfer(int display);
    ::tlm::tlm_sync_enum take_notice(Payload& payload, Phase& phase, sc_core::sc_time& delay);
    void wait_for_arbiter(std::int64_t clocks);

    // ---- shared ports ----
    /// What a frame on the link has written: blocks of words, in order.
    struct LinkWrites {
        bool placed = true;           ///< it is known which image of the memory they belong to
        std::int64_t next_word = 0;   ///< of the next block, in the image
        std::int64_t first_word = 0;  ///< of the image, in the memory
    };
    std::int64_t first_word_of(bool device) const {
        const MemoryConfig& memory = scenario_.memory;
        return memory.shared() && device ? memory.device_words(renderer_.image_words()) : std::int64_t{0};
    }
    std::int64_t next_block_words() const;
    bool has_next_block() const;
    std::int64_t next_block_cycle() const;
    void write_blocks(std::int64_t cycle);
    void write_block();
    std::int64_t writes_known_before() const;

    const Scenario& scenario_;
    const Renderer& renderer_;
    Agenda& agenda_;
    std::size_t bus_;  ///< number on the agenda
    Settings settings_;
    ViewportLimits limits_;
    ClockDomain core_;
    ClockDomain dvi_;
    int pixels_per_beat_;
    int cycles_per_beat_;
    int delay_cycles_;  ///< a beat reaches the composers this much later
    int loop_cycles_;   ///< and its answer is read this much later

    // The link's side.
    /// A whole pair.
    struct Pair {
        ViewportTable rows;
        std::vector<int> slots;  ///< rows by slot
        FrameSource source;
        const StoredImage* colour = nullptr;
        const StoredImage* depth = nullptr;
    };
    sc_core::sc_event link_wake_;
    std::deque<LinkEvent> link_events_;
    LinkPixels link_frame_;  ///< the newest
    std::int64_t link_pixels_before_ = 0;
    PairKeeper banks_;
    ViewportTable filling_table_;  ///< of the pair under way
    Pair back_;
    Pair front_;
    FrameContent front_content_;
    std::int64_t request_edge_ = kUnknownCycle;  ///< at which the request is seen
    bool front_device_ = false;                  ///< of the memory, numbered as at level rtl
    LinkWrites link_writes_;
    std::int64_t newest_block_cycle_ = -1;  ///< of the last block reported to the memory

    // The bus side.
    State state_ = State::kSend;
    std::int64_t next_cycle_;  ///< of the next decision
    int frames_started_ = 0;
    std::vector<Row> rows_;
    std::vector<BusRequest> requests_;
    std::int64_t pixels_left_ = 0;
    std::unique_ptr<ArbitrationPolicy> policy_;
    std::array<TableReady, kFramesKept> table_ready_{};
    bool new_frame_ = false;  ///< the memory has not been accessed yet
    // The burst under way.
    int burst_row_ = 0;
    int burst_left_ = 0;
    int burst_beats_ = 0;
    int last_beat_pixels_ = 0;
    int recovered_slots_ = 0;
    MachineEvent first_recovered_slot_;
    std::int64_t slot_table_cycle_ = 0;  ///< from which the frame's slot table is ready
    std::int64_t at_cycle_ = 0;          ///< of the next beat or page miss
    bool accessing_ = false;             ///< the memory has been asked for the words from at_cycle_ on
    bool may_cut_ = false;
    std::deque<BurstBeat> unjudged_;           ///< beats at which BUSREADY is not known yet
    std::int64_t stop_cycle_ = kUnknownCycle;  ///< of the burst: BUSREADY's fall is read
    std::vector<std::int64_t>
        counted_from_;  ///< [display]: BUSREADY before this clock does not count all that was sent
    std::int64_t table_counted_from_ = 0;  ///< TABLEREADY before it does not count the newest frame

    Message<MemoryAccess> memory_access_;
    Message<BusTransfer> bus_transfer_;

    RendererCounters counters_;  ///< without those of the bus
    BusRecord record_;
    std::vector<FrameSource> frame_sources_;
};

}  // namespace metabuffer::tlm
