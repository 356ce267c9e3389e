#pragma once

#include <cstdint>
#include <optional>

#include "datapath/link/pacing.h"
#include "datapath/link/pair_event.h"
#include "formats/control_scanline.h"

namespace metabuffer {

/// Keeps track of the pairs in the two devices of an input framebuffer (section 4 of the paper): the front device, which
/// the bus reads, and the back device, which the link fills. It decides which pairs are dropped, and how the bus side is
/// answered when it asks for the pair of its next frame; docs/design.md has the table of the answers.
///
/// It has no clock and keeps no pixels. Each call has the number of the link's clock edge at which it is made; numbers
/// ascend. Call it at each edge with an event or a question, and at next_timer():
///
///     const PairKeeper::Taken taken = pairs.take(event, edge);  // from the decoder
///     if (asked) pairs.ask();
///     if (const auto answer = pairs.answer(edge)) ...           // kFresh: the devices are swapped
///     pairs.wants_pair();                                       // what the source is asked for
class PairKeeper {
  public:
    enum class Answer : std::uint8_t {
        kFresh,  ///< the devices are swapped: the pair is one that no frame has been made of
        kAgain,  ///< the front pair again; none before the first pair
    };
    /// What an event does besides filling the back device.
    struct Taken {
        int dropped_pairs = 0;       ///< whole pairs that no frame is made of
        bool pair_accepted = false;  ///< the back device holds the event's pair, whole
    };

    /// pair_clocks: link clocks of a pair. timeout_clocks: how many the bus side waits for a pair.
    PairKeeper(Pacing pacing, std::int64_t pair_clocks, std::int64_t timeout_clocks)
        : pacing_(pacing), pair_clocks_(pair_clocks), timeout_clocks_(timeout_clocks) {}

    /// An edge that sees reset: no pair, no question, and the first pair wanted is number 0.
    void reset(std::int64_t edge);
    Taken take(const PairEvent& event, std::int64_t edge);
    /// The bus side wants the pair of its next frame. One question at a time.
    void ask() { asked_ = true; }
    /// There is an open question, and the time to answer it has come.
    bool can_answer(std::int64_t edge) const { return asked_ && due_answer(edge).has_value(); }
    /// Answers the open question, if there is one and the time has come.
    std::optional<Answer> answer(std::int64_t edge);

    /// The back device is free for another pair, or is being filled.
    bool wants_pair() const { return back_ != Back::kWhole; }
    /// Number of the last whole pair that the back device has held.
    std::uint32_t back_number() const { return back_number_; }
    /// The first edge after `edge` at which the open question could be answered without an event; none without a question
    /// or a timer.
    std::optional<std::int64_t> next_timer(std::int64_t edge) const;

    enum class Back : std::uint8_t { kFree, kFilling, kWhole };

    /// Calls see(name, value, largest value) for each register but the timers, which are kept as edges.
    template <typename See>
    void visit_state(const See& see) const {
        see("back", back_, 2);
        see("back_number", back_number_, kLargestFrameNumber);
        see("front_valid", front_valid_, 1);
        see("superseded", superseded_, 1);
        see("pair_lost", pair_lost_, 1);
        see("lost_pair", lost_pair_, kLargestFrameNumber);
        see("asked", asked_, 1);
        see("wanted_pair", wanted_pair_, kLargestFrameNumber);
    }

  private:
    std::optional<Answer> due_answer(std::int64_t edge) const;
    /// A pair is coming in: its colour frame has begun less than a pair time ago.
    bool pair_under_way(std::int64_t edge) const {
        return back_ == Back::kFilling && edge < filling_end_edge();
    }
    bool timed_out(std::int64_t edge) const { return edge >= timeout_edge() && !pair_under_way(edge); }
    std::int64_t filling_end_edge() const { return filling_since_edge_ + pair_clocks_; }
    std::int64_t timeout_edge() const { return timeout_start_edge_ + timeout_clocks_; }

    Pacing pacing_;
    std::int64_t pair_clocks_;
    std::int64_t timeout_clocks_;

    Back back_ = Back::kFree;
    std::uint32_t back_number_ = 0;
    std::int64_t filling_since_edge_ = 0;
    bool front_valid_ = false;
    bool superseded_ = false;  ///< a whole pair newer than the front one has been overwritten
    bool pair_lost_ = false;   ///< lost_pair_ is the number of a pair that will not come
    std::uint32_t lost_pair_ = 0;
    bool asked_ = false;
    std::uint32_t wanted_pair_ = 0;        ///< number of the composited frame that is asked for next
    std::int64_t timeout_start_edge_ = 0;  ///< reset, the last answer, or the last pair that came too late
};

}  // namespace metabuffer
