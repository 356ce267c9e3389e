#pragma once

#include <array>
#include <cstdint>

#include "datapath/link/pair_event.h"
#include "formats/control_scanline.h"

namespace metabuffer {

/// Finds the pairs among the frames of a link (section 4 of the paper): which two frames make a pair, which frame is
/// rejected and for what, and which pair can no longer come. It has no clock: a decoder reports to it what it sees, in
/// the clock in which it sees it.
///
///     follower.begin_frame();                         // VSYNC: a frame may come
///     follower.end_control_scanline(decoded, event);  // its first line is whole
///     follower.reject_geometry(event);                // a line is too short or too long, or is one too many
///     follower.end_frame(whole, event);               // VSYNC after a frame of one line or more
///
/// Each call adds its results to `event`. It adds none while no frame is followed (in_frame()): the frame has been
/// rejected or ignored, or no VSYNC has been seen.
class PairFollower {
  public:
    /// The frame that must come next.
    enum class Expect : std::uint8_t {
        kAnyColour,  ///< not in step yet: everything except a good colour frame is ignored
        kColour,     ///< the last pair is whole
        kDepth,      ///< of pair number()
    };

    /// Goes back to the state before the first VSYNC. What has been rejected stays counted.
    void reset();
    void begin_frame();
    void end_control_scanline(const DecodedScanline& scanline, PairEvent& event);
    void reject_geometry(PairEvent& event);
    /// whole: every line of the mode has come.
    void end_frame(bool whole, PairEvent& event);

    bool in_frame() const { return in_frame_; }
    /// Of the frame under way, once its control scanline is known to be good.
    FrameKind kind() const { return kind_; }
    Expect expect() const { return expect_; }
    std::uint32_t number() const { return number_; }  ///< of the pair under way
    /// Frames and pairs rejected so far, by RejectCause.
    const std::array<std::int64_t, kRejectCauseCount>& rejected() const { return rejected_; }

    /// Calls see(name, value, largest value) for each register; what is counted for the report is none.
    template <typename See>
    void visit_state(const See& see) const {
        see("in_frame", in_frame_, 1);
        see("colour_begun", colour_begun_, 1);
        see("kind", kind_, 1);
        see("expect", expect_, 2);
        see("number", number_, kLargestFrameNumber);
    }

  private:
    void begin_colour(std::uint32_t number, PairEvent& event);
    void begin_depth(std::uint32_t number, PairEvent& event);
    void reject(RejectCause cause, PairEvent& event);

    bool in_frame_ = false;
    bool colour_begun_ = false;  ///< the frame under way is the good colour frame of pair number_
    FrameKind kind_ = FrameKind::kColour;
    Expect expect_ = Expect::kAnyColour;
    std::uint32_t number_ = 0;
    std::array<std::int64_t, kRejectCauseCount> rejected_{};
};

}  // namespace metabuffer
