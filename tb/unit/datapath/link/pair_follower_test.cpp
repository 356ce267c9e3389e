#include "datapath/link/pair_follower.h"

#include <array>
#include <catch2/catch.hpp>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace metabuffer {
namespace {

// ---- what comes over a link ----

enum class Top { kNoLine, kWrongLength, kMagic, kVersion, kCrc, kKind, kColour, kDepth };
enum class Rest { kWhole, kBadLine, kLinesMissing, kReset };

/// A frame, or what is left of one: its control scanline, and how the rest of it comes.
struct SentFrame {
    Top top = Top::kNoLine;
    std::uint32_t number = 0;
    Rest rest = Rest::kWhole;
};

std::string name_of(const SentFrame& frame) {
    const std::array<const char*, 8> tops{"no line", "short line", "bad magic", "bad version",
                                          "bad CRC", "bad kind",   "colour",    "depth"};
    const std::array<const char*, 4> rests{"", " with a bad line", " with lines missing", " until a reset"};
    return std::string(tops[static_cast<std::size_t>(frame.top)]) + " " + std::to_string(frame.number) +
           rests[static_cast<std::size_t>(frame.rest)];
}

/// What must be reported about a frame.
struct Verdict {
    PairEvent at_control;         ///< after its control scanline
    bool reaches_memory = false;  ///< its pixels do
    PairEvent at_end;             ///< at the line that is wrong, or at the VSYNC after it
};

PairEvent rejection(RejectCause cause, std::optional<std::uint32_t> lost) {
    PairEvent event;
    event.rejected = true;
    event.cause = cause;
    event.pair_lost = lost.has_value();
    event.lost_number = lost.value_or(0);
    return event;
}

// ---- the reference: whole frames, judged by the outcome of the frame before ----

/// The state that the frames so far have left.
struct Outcome {
    enum class Kind { kNothing, kColourTaken, kPairWhole };
    Kind kind = Kind::kNothing;
    std::uint32_t pair = 0;
};

/// Written from the text of docs/design.md, "The link and the input framebuffer". It shares no code with the model.
class Judge {
  public:
    Verdict judge(const SentFrame& frame) {
        const Outcome before = outcome_;
        // A bad frame in place of its depth frame ends the pair whose colour frame was received.
        std::optional<std::uint32_t> open_pair;
        if (before.kind == Outcome::Kind::kColourTaken) open_pair = before.pair;
        Verdict verdict;
        if (frame.top == Top::kNoLine) {
            if (frame.rest == Rest::kReset) outcome_ = {};
            return verdict;  // two VSYNCs, no frame
        }
        outcome_ = {};
        if (frame.top < Top::kColour) {
            const RejectCause cause = cause_of(frame.top);
            count(cause);
            (cause == RejectCause::kGeometry ? verdict.at_end : verdict.at_control) =
                rejection(cause, open_pair);
            return verdict;
        }
        if (frame.top == Top::kColour) {
            // "a colour frame that got no depth frame", unless this is the same one again
            if (open_pair) {
                const bool again = *open_pair == frame.number;
                verdict.at_control =
                    rejection(RejectCause::kPair, again ? std::optional<std::uint32_t>() : open_pair);
                count(RejectCause::kPair);
            }
            verdict.at_control.colour_start = true;
            verdict.at_control.number = frame.number;
            verdict.reaches_memory = true;
        } else if (open_pair == frame.number) {
            verdict.reaches_memory = true;
        } else if (before.kind == Outcome::Kind::kNothing) {
            // "the decoder ignores good depth frames"; their pair can no longer come
            verdict.at_control.pair_lost = true;
            verdict.at_control.lost_number = frame.number;
        } else if (open_pair) {
            // "of another number": of the two pairs the later one may still come
            const bool counts_up = static_cast<std::uint32_t>(frame.number - *open_pair) < 0x8000'0000U;
            verdict.at_control = rejection(RejectCause::kPair, counts_up ? *open_pair : frame.number);
            count(RejectCause::kPair);
        } else {
            // "a second depth frame after its whole pair", or "a depth frame without its colour frame"
            const bool again = before.pair == frame.number;
            verdict.at_control =
                rejection(RejectCause::kPair, again ? std::optional<std::uint32_t>() : frame.number);
            count(RejectCause::kPair);
        }
        if (!verdict.reaches_memory || frame.rest == Rest::kReset) return verdict;
        if (frame.rest != Rest::kWhole) {
            verdict.at_end = rejection(RejectCause::kGeometry, frame.number);
            count(RejectCause::kGeometry);
        } else if (frame.top == Top::kColour) {
            outcome_ = {Outcome::Kind::kColourTaken, frame.number};
        } else {
            outcome_ = {Outcome::Kind::kPairWhole, frame.number};
            verdict.at_end.pair_good = true;
            verdict.at_end.number = frame.number;
        }
        return verdict;
    }

    const Outcome& outcome() const { return outcome_; }
    const std::array<std::int64_t, kRejectCauseCount>& rejected() const { return rejected_; }

  private:
    static RejectCause cause_of(Top top) {
        if (top == Top::kMagic) return RejectCause::kMagic;
        if (top == Top::kVersion) return RejectCause::kVersion;
        if (top == Top::kCrc) return RejectCause::kCrc;
        return top == Top::kKind ? RejectCause::kKind : RejectCause::kGeometry;
    }
    void count(RejectCause cause) { ++rejected_[static_cast<std::size_t>(cause)]; }

    Outcome outcome_;
    std::array<std::int64_t, kRejectCauseCount> rejected_{};
};

// ---- the follower at the same link ----

DecodedScanline decoded(const SentFrame& frame) {
    DecodedScanline scanline;
    switch (frame.top) {
        case Top::kMagic:
            scanline.defect = ScanlineDefect::kMagic;
            break;
        case Top::kVersion:
            scanline.defect = ScanlineDefect::kVersion;
            break;
        case Top::kCrc:
            scanline.defect = ScanlineDefect::kCrc;
            break;
        case Top::kKind:
            scanline.defect = ScanlineDefect::kKind;
            break;
        default:
            scanline.content.kind = frame.top == Top::kDepth ? FrameKind::kDepth : FrameKind::kColour;
            scanline.content.frame_number = frame.number;
    }
    return scanline;
}

/// Between two VSYNCs; the follower has seen the first.
Verdict follow(PairFollower& follower, const SentFrame& frame) {
    Verdict verdict;
    if (frame.top == Top::kWrongLength) {
        follower.reject_geometry(verdict.at_end);
    } else if (frame.top != Top::kNoLine) {
        follower.end_control_scanline(decoded(frame), verdict.at_control);
        verdict.reaches_memory = follower.in_frame();
    }
    if (frame.rest == Rest::kBadLine) follower.reject_geometry(verdict.at_end);
    if (frame.rest == Rest::kReset) follower.reset();
    if (frame.top != Top::kNoLine) follower.end_frame(frame.rest != Rest::kLinesMissing, verdict.at_end);
    follower.begin_frame();
    return verdict;
}

bool same(const PairEvent& a, const PairEvent& b) {
    return a.rejected == b.rejected && (!a.rejected || a.cause == b.cause) && a.pair_lost == b.pair_lost &&
           (!a.pair_lost || a.lost_number == b.lost_number) && a.colour_start == b.colour_start &&
           a.pair_good == b.pair_good && (!(a.colour_start || a.pair_good) || a.number == b.number) &&
           a.reports_anything() == (b.rejected || b.pair_lost || b.colour_start || b.pair_good);
}

bool same(const PairFollower& follower, const Judge& judge) {
    if (follower.rejected() != judge.rejected()) return false;
    switch (judge.outcome().kind) {
        case Outcome::Kind::kNothing:
            return follower.expect() == PairFollower::Expect::kAnyColour;
        case Outcome::Kind::kColourTaken:
            return follower.expect() == PairFollower::Expect::kDepth &&
                   follower.number() == judge.outcome().pair;
        case Outcome::Kind::kPairWhole:
            return follower.expect() == PairFollower::Expect::kColour;
    }
    return false;
}

/// Every sequence of this many frames out of an alphabet. Sequences with the same beginning share its state.
class Sequences {
  public:
    Sequences(std::vector<SentFrame> alphabet, std::size_t length)
        : alphabet_(std::move(alphabet)), length_(length) {}

    void check() {
        PairFollower follower;
        follower.begin_frame();
        go_on(follower, Judge());
    }
    std::int64_t frames_judged() const { return frames_judged_; }
    std::int64_t pairs_good() const { return pairs_good_; }

  private:
    void go_on(const PairFollower& follower, const Judge& judge) {
        if (sent_.size() == length_) return;
        for (const SentFrame& frame : alphabet_) {
            sent_.push_back(frame);
            PairFollower next_follower = follower;
            Judge next_judge = judge;
            const Verdict verdict = follow(next_follower, frame);
            const Verdict due = next_judge.judge(frame);
            ++frames_judged_;
            pairs_good_ += due.at_end.pair_good ? 1 : 0;
            if (!same(verdict.at_control, due.at_control) || !same(verdict.at_end, due.at_end) ||
                verdict.reaches_memory != due.reaches_memory || !same(next_follower, next_judge)) {
                std::string text;
                for (const SentFrame& sent : sent_) text += name_of(sent) + ", ";
                FAIL("reported otherwise for the last of: " << text);
            }
            go_on(next_follower, next_judge);
            sent_.pop_back();
        }
    }

    std::vector<SentFrame> alphabet_;
    std::size_t length_;
    std::vector<SentFrame> sent_;
    std::int64_t frames_judged_ = 0;
    std::int64_t pairs_good_ = 0;
};

TEST_CASE("pair follower: every sequence of four frames of every kind is judged as the rules say") {
    std::vector<SentFrame> alphabet;
    for (const Top top :
         {Top::kMagic, Top::kVersion, Top::kCrc, Top::kKind, Top::kWrongLength, Top::kNoLine}) {
        alphabet.push_back({top, 0, Rest::kWhole});
    }
    alphabet.push_back({Top::kNoLine, 0, Rest::kReset});
    for (const Top top : {Top::kColour, Top::kDepth}) {
        for (const Rest rest : {Rest::kWhole, Rest::kBadLine, Rest::kLinesMissing, Rest::kReset}) {
            for (const std::uint32_t number : {0U, 1U}) alphabet.push_back({top, number, rest});
        }
    }
    Sequences sequences(alphabet, 4);
    sequences.check();
    CHECK(sequences.frames_judged() == 23 + 23 * 23 + 23 * 23 * 23 + 23 * 23 * 23 * 23);
    CHECK(sequences.pairs_good() > 0);
}

TEST_CASE("pair follower: every sequence of six frames of three pairs is judged as the rules say") {
    // The numbers of a pair count modulo 2^32.
    for (const std::uint32_t first : {0U, 0xffff'fffeU, 0x7fff'ffffU}) {
        std::vector<SentFrame> alphabet{{Top::kCrc, 0, Rest::kWhole}};
        for (std::uint32_t pair = 0; pair < 3; ++pair) {
            alphabet.push_back({Top::kColour, first + pair, Rest::kWhole});
            alphabet.push_back({Top::kDepth, first + pair, Rest::kWhole});
        }
        alphabet.push_back({Top::kColour, first + 1, Rest::kBadLine});
        Sequences sequences(alphabet, 6);
        sequences.check();
        CHECK(sequences.pairs_good() > 0);
    }
}

TEST_CASE(
    "pair follower: nothing is reported before the first VSYNC, nor about a frame that a reset cuts off") {
    PairFollower follower;
    for (int time = 0; time < 2; ++time) {
        PairEvent event;
        follower.end_control_scanline(decoded({Top::kColour, 0, Rest::kWhole}), event);
        follower.end_control_scanline(decoded({Top::kCrc, 0, Rest::kWhole}), event);
        follower.reject_geometry(event);
        follower.end_frame(true, event);
        follower.end_frame(false, event);
        CHECK_FALSE(event.reports_anything());
        CHECK_FALSE(follower.in_frame());
        CHECK(follower.rejected() == std::array<std::int64_t, kRejectCauseCount>{});
        follower.begin_frame();
        PairEvent colour;
        follower.end_control_scanline(decoded({Top::kColour, 0, Rest::kWhole}), colour);
        CHECK(colour.colour_start);
        follower.reset();
    }
}

TEST_CASE("pair follower: a new report is added to what the event reports already") {
    PairFollower follower;
    follower.begin_frame();
    PairEvent event;
    follower.end_control_scanline(decoded({Top::kColour, 7, Rest::kWhole}), event);
    follower.reject_geometry(event);
    CHECK(event.colour_start);
    CHECK(event.number == 7);
    CHECK(event.rejected);
    CHECK(event.cause == RejectCause::kGeometry);
    CHECK(event.pair_lost);
    CHECK(event.lost_number == 7);
}

}  // namespace
}  // namespace metabuffer
