#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "datapath/arbitration/arbitration_table.h"
#include "formats/dvi_timing.h"
#include "scenario/scenario.h"

/// What a renderer's link carries, frame by frame, with the faults that the scenario asks for. Every level that has
/// time sends these frames.
namespace metabuffer {

/// One frame as it is on the link.
struct LinkFrame {
    std::vector<std::uint32_t> control;        ///< link pixels of the control scanline
    std::shared_ptr<const StoredImage> image;  ///< the lines below it
    bool image_is_copy = false;                ///< made for this frame, with flipped bits
    int active_lines = 0;                      ///< control scanline included; lines beyond the image are 0
    int last_line_pixels = 0;                  ///< of the last line; a pixel beyond the image is 0
    std::int64_t faults = 0;                   ///< that change it
};

/// The slot table of a pair, as indices of the valid rows of `table`: from the host's payload in the depth frame's control
/// scanline, or made by the hardware; none under a policy without slots.
SentSlots machine_slots(const BusConfig& bus, const ValidatedTable& table,
                        const std::vector<std::uint8_t>& payload);

/// The same for an undisturbed frame of the entry. table: the entry's, validated.
SentSlots frame_slots(const Scenario& scenario, const Renderer& renderer, const RendererFrame& entry,
                      const ValidatedTable& table);

/// The content of a frame's control scanline: the colour frame has the viewport table, the depth frame the slot table, if
/// the host makes it.
ControlScanline control_content(const Scenario& scenario, const Renderer& renderer, std::uint32_t pair,
                                FrameKind frame);

/// The frame that is sent as `frame` of a pair. The scenario must have passed check_scenario.
LinkFrame link_frame(const Scenario& scenario, int renderer, std::uint32_t pair, FrameKind frame);

/// Which frame or silence comes next on a link.
class LinkProgram {
  public:
    enum class Step : std::uint8_t {
        kNothing,  ///< the link stays in blanking: no pair is asked for
        kSilence,  ///< for silence_clocks()
        kFrame,    ///< frame()
    };

    /// The scenario must outlive the program. renderer: index, from 0.
    LinkProgram(const Scenario& scenario, int renderer);

    /// What begins in this clock of the link. To be called while neither frame nor silence is under way.
    Step next(bool pair_requested);
    /// Whether faults disturb characters of frame(). If so, call begin_clock in each of its clocks.
    bool disturbs_characters() const { return !character_faults_.empty(); }
    /// A clock of the frame: line and clock in it, from 0.
    void begin_clock(int line, int clock);
    /// The frame of the last next() has been sent.
    void end_frame();
    /// The link starts again; the counts stay.
    void reset();

    const LinkFrame& frame() const { return frame_; }
    FrameKind kind() const { return kind_; }
    std::int64_t silence_clocks() const { return silence_clocks_; }
    bool pair_under_way() const { return pair_under_way_; }
    const std::uint32_t& pair() const { return pair_; }  ///< the pair under way, or the last one
    std::uint32_t next_pair() const { return next_pair_; }
    bool all_pairs_sent() const { return next_pair_ >= static_cast<std::uint32_t>(scenario_.frames); }
    /// Millionths that the link's clock runs fast: of the newest drift fault whose pair has begun.
    int clock_ppm() const { return clock_ppm_; }
    /// What the faults do to the characters of the clock that has begun last.
    const TmdsDisturbance& disturbance() const { return disturbance_; }
    /// Faults that have taken effect, each when its frame, its character, its silence or its second sending began.
    std::int64_t injected_faults() const { return injected_faults_; }

  private:
    const Fault* fault_of(FaultKind kind) const;
    void begin_pair();
    void next_frame();
    std::vector<const Fault*> character_faults_of_frame() const;

    const Scenario& scenario_;
    const Renderer& renderer_;
    int renderer_index_;

    std::uint32_t next_pair_ = 0;
    std::uint32_t pair_ = 0;
    LivePairs::Next live_ = LivePairs::Next::kPair;  ///< what came of the pair under way, if the link is live
    bool pair_under_way_ = false;
    FrameKind kind_ = FrameKind::kColour;
    bool delay_served_ = false;
    bool send_again_ = false;
    bool sent_again_ = false;
    std::int64_t silence_clocks_ = 0;
    LinkFrame frame_;
    std::vector<const Fault*> character_faults_;  ///< of that frame
    TmdsDisturbance disturbance_;
    int clock_ppm_ = 0;
    std::int64_t injected_faults_ = 0;
};

}  // namespace metabuffer
