#include "datapath/link/pair_keeper.h"

namespace metabuffer {

void PairKeeper::reset(std::int64_t edge) {
    *this = PairKeeper(pacing_, pair_clocks_, timeout_clocks_);
    timeout_start_edge_ = edge;
}

PairKeeper::Taken PairKeeper::take(const PairEvent& event, std::int64_t edge) {
    Taken taken;
    if (event.rejected && back_ == Back::kFilling) {
        back_ = Back::kFree;
    }
    if (event.pair_lost) {
        pair_lost_ = true;
        lost_pair_ = event.lost_number;
    }
    if (event.colour_start) {
        if (back_ == Back::kWhole) {
            ++taken.dropped_pairs;
            superseded_ = true;
        }
        back_ = Back::kFilling;
        filling_since_edge_ = edge;
    }
    if (event.pair_good) {
        // Frame numbers count modulo 2^32.
        const bool too_late = static_cast<std::int32_t>(event.number - wanted_pair_) < 0;
        if (pacing_ == Pacing::kLockstep && too_late) {
            ++taken.dropped_pairs;
            back_ = Back::kFree;
            timeout_start_edge_ = edge;  // the source sends its next pair only now
        } else {
            taken.pair_accepted = true;
            back_ = Back::kWhole;
            back_number_ = event.number;
        }
    }
    return taken;
}

std::optional<PairKeeper::Answer> PairKeeper::answer(std::int64_t edge) {
    const std::optional<Answer> answer = asked_ ? due_answer(edge) : std::nullopt;
    if (!answer) {
        return std::nullopt;
    }
    if (*answer == Answer::kFresh) {
        front_valid_ = true;
        superseded_ = false;
        back_ = Back::kFree;
    }
    asked_ = false;
    ++wanted_pair_;
    timeout_start_edge_ = edge;
    return answer;
}

std::optional<PairKeeper::Answer> PairKeeper::due_answer(std::int64_t edge) const {
    bool again = timed_out(edge);
    if (pacing_ == Pacing::kFreeRunning) {
        if (back_ == Back::kWhole) {
            return Answer::kFresh;
        }
        if (superseded_ && pair_under_way(edge)) {
            // A newer pair has been overwritten. A machine slower than the link would hardly ever find a whole one
            // between two overwrites, so it waits for the pair under way.
            return std::nullopt;
        }
        again = again || front_valid_;
    } else {
        if (back_ == Back::kWhole) {
            // A later pair: the wanted one will not come any more.
            return back_number_ == wanted_pair_ ? Answer::kFresh : Answer::kAgain;
        }
        again = again || (pair_lost_ && lost_pair_ == wanted_pair_);
    }
    return again ? std::optional<Answer>(Answer::kAgain) : std::nullopt;
}

std::optional<std::int64_t> PairKeeper::next_timer(std::int64_t edge) const {
    std::optional<std::int64_t> next;
    if (asked_) {
        for (const std::int64_t end : {timeout_edge(), filling_end_edge()}) {
            if (end > edge && (!next || end < *next)) {
                next = end;
            }
        }
    }
    return next;
}

}  // namespace metabuffer
