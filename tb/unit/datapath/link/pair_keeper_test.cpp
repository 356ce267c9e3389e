#include "datapath/link/pair_keeper.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "support/random_seed.h"

namespace metabuffer {
namespace {

using Answer = PairKeeper::Answer;

/// A link as far as the banks are concerned.
struct Link {
    Pacing pacing = Pacing::kLockstep;
    std::int64_t pair_clocks = 0;
    std::int64_t timeout_clocks = 0;
};

/// What happens at a clock edge of the link.
struct Step {
    PairEvent event;
    bool asks = false;
    bool reset = false;
};

std::string name_of(const Step& step) {
    std::string name = step.reset ? "reset " : "";
    if (step.event.rejected) name += "rejected ";
    if (step.event.pair_lost) name += "lost " + std::to_string(step.event.lost_number) + " ";
    if (step.event.colour_start) name += "colour ";
    if (step.event.pair_good) name += "good " + std::to_string(step.event.number) + " ";
    return name + (step.asks ? "asked" : "") + "; ";
}

// ---- the reference: everything is computed again from the list of events ----

/// Written from the text of docs/design.md, "The link and the input framebuffer". It keeps no state except for the list
/// of events, and shares no code with the model.
class Story {
  public:
    explicit Story(const Link& link) : link_(link) {}

    /// One edge. Answers as the table of answers says.
    std::optional<Answer> happen(const Step& step) {
        if (step.reset) told_.clear();  // time goes on
        told_.push_back({now_++, step, std::nullopt});
        told_.back().answer = step.reset || !asked() ? std::nullopt : due();
        return told_.back().answer;
    }

    bool asked() const {
        return count([](const Entry& entry) { return entry.step.asks; }) >
               count([](const Entry& entry) { return entry.answer.has_value(); });
    }
    bool pair_stands_in_back_bank() const { return back(told_.size()).whole; }
    std::uint32_t wanted() const { return wanted_before(told_.size()); }
    /// Whether the newest event's pair has been accepted, and how many pairs it has cost.
    bool taken() const { return told_.back().step.event.pair_good && !too_late(told_.size() - 1); }
    int dropped() const {
        const PairEvent& event = told_.back().step.event;
        return (event.pair_good && too_late(told_.size() - 1) ? 1 : 0) +
               (event.colour_start && back(told_.size() - 1).whole ? 1 : 0);
    }

  private:
    struct Entry {
        std::int64_t at = 0;
        Step step;
        std::optional<Answer> answer;
    };
    struct Back {
        bool whole = false;
        std::uint32_t number = 0;
        std::optional<std::int64_t> coming_since;
    };

    template <typename Condition>
    std::int64_t count(Condition condition) const {
        return std::count_if(told_.begin(), told_.end(), condition);
    }

    std::uint32_t wanted_before(std::size_t entries) const {
        std::uint32_t answers = 0;
        for (std::size_t i = 0; i < entries; ++i) answers += told_[i].answer ? 1 : 0;
        return answers;
    }

    /// "In lockstep a late pair, whose frame has been composited without it, is dropped when it comes."
    bool too_late(std::size_t entry) const {
        const std::uint32_t behind = wanted_before(entry) - told_[entry].step.event.number;
        return link_.pacing == Pacing::kLockstep && behind != 0 && behind < 0x8000'0000U;
    }

    /// What the back device holds after this many entries, by the newest entry that has changed it.
    Back back(std::size_t entries) const {
        bool rejected_since = false;
        for (std::size_t i = entries; i-- > 0;) {
            const Entry& entry = told_[i];
            if (entry.answer == Answer::kFresh) return {};  // swapped
            if (entry.step.event.pair_good) {
                if (too_late(i)) return {};
                return {true, entry.step.event.number, std::nullopt};
            }
            if (entry.step.event.colour_start) {
                if (rejected_since) return {};
                return {false, 0, entry.at};
            }
            rejected_since = rejected_since || entry.step.event.rejected;
        }
        return {};
    }

    /// The table of answers.
    std::optional<Answer> due() const {
        const Back held = back(told_.size());
        const bool coming = held.coming_since && told_.back().at - *held.coming_since < link_.pair_clocks;
        std::int64_t waiting_since = told_.front().at;
        for (std::size_t i = 0; i < told_.size(); ++i) {
            const bool dropped_late = told_[i].step.event.pair_good && too_late(i);
            if (told_[i].answer || dropped_late) waiting_since = told_[i].at;
        }
        const bool timeout = !coming && told_.back().at - waiting_since >= link_.timeout_clocks;
        if (link_.pacing == Pacing::kLockstep) {
            if (held.whole) return held.number == wanted() ? Answer::kFresh : Answer::kAgain;
            const auto lost = std::find_if(told_.rbegin(), told_.rend(),
                                           [](const Entry& entry) { return entry.step.event.pair_lost; });
            const bool wanted_is_lost = lost != told_.rend() && lost->step.event.lost_number == wanted();
            return wanted_is_lost || timeout ? std::optional<Answer>(Answer::kAgain) : std::nullopt;
        }
        if (held.whole) return Answer::kFresh;
        const auto swap = std::find_if(told_.rbegin(), told_.rend(),
                                       [](const Entry& entry) { return entry.answer == Answer::kFresh; });
        const bool has_front = swap != told_.rend();
        if (!has_front) return timeout ? std::optional<Answer>(Answer::kAgain) : std::nullopt;
        bool overwritten = false;
        for (auto i = static_cast<std::size_t>(told_.rend() - swap); i < told_.size(); ++i) {
            overwritten = overwritten || (told_[i].step.event.colour_start && back(i).whole);
        }
        return overwritten && coming ? std::nullopt : std::optional<Answer>(Answer::kAgain);
    }

    Link link_;
    std::int64_t now_ = 1;
    std::vector<Entry> told_{{0, {}, std::nullopt}};  ///< since reset
};

// ---- both side by side ----

struct Banks {
    PairKeeper keeper;
    Story story;
    std::int64_t edge = 0;
    std::optional<Answer> answer;  ///< at this edge

    explicit Banks(const Link& link)
        : keeper(link.pacing, link.pair_clocks, link.timeout_clocks), story(link) {
        keeper.reset(edge);
    }
    /// Returns false if the two differ.
    bool agree(const Step& step) {
        ++edge;
        const std::optional<std::int64_t> timer = keeper.next_timer(edge - 1);
        answer = story.happen(step);
        if (step.reset) {
            keeper.reset(edge);
            return keeper.wants_pair() && !keeper.answer(edge);
        }
        const PairKeeper::Taken taken = keeper.take(step.event, edge);
        if (step.asks) keeper.ask();
        // If nothing happens, only a timer that has been announced brings an answer.
        const bool quiet = !step.asks && !step.event.reports_anything();
        const bool foretold = !quiet || !answer || timer == edge;
        return taken.dropped_pairs == story.dropped() && taken.pair_accepted == story.taken() &&
               keeper.answer(edge) == answer && foretold &&
               keeper.wants_pair() != story.pair_stands_in_back_bank();
    }
};

/// What may come at an edge: nothing, a question, and a decoder's events about the wanted pair, the one before and the
/// one after it.
std::vector<Step> steps(const Story& story) {
    std::vector<Step> all(2);
    all[0].reset = true;
    const auto add = [&all](auto&& change) { change(all.emplace_back().event); };
    add([](PairEvent& event) { event.colour_start = true; });
    add([](PairEvent& event) { event.rejected = true; });
    for (const std::uint32_t off : {0U, 1U, ~0U}) {
        const std::uint32_t number = story.wanted() + off;
        add([=](PairEvent& event) { event.pair_good = true, event.number = number; });
        add([=](PairEvent& event) { event.pair_lost = true, event.lost_number = number; });
    }
    add([&story](PairEvent& event) {
        event.rejected = event.pair_lost = event.colour_start = true;
        event.lost_number = story.wanted();
        event.number = story.wanted() + 1;
    });
    if (!story.asked()) {
        const std::size_t unasked = all.size();
        for (std::size_t i = 1; i < unasked; ++i) {
            all.push_back(all[i]);
            all.back().asks = true;
        }
    }
    return all;
}

class Stories {
  public:
    std::int64_t steps_taken = 0;
    std::int64_t fresh = 0;
    std::int64_t again = 0;

    void check_all(const Banks& keeper, std::size_t length) {
        if (length == 0) return;
        for (const Step& step : steps(keeper.story)) {
            Banks next = keeper;
            take(next, step);
            check_all(next, length - 1);
            taken_.pop_back();
        }
    }
    void take(Banks& keeper, const Step& step) {
        taken_.push_back(step);
        ++steps_taken;
        if (!keeper.agree(step)) {
            std::string text;
            for (const Step& taken : taken_) text += name_of(taken);
            FAIL("different at the last of: " << text);
        }
        fresh += keeper.answer == Answer::kFresh ? 1 : 0;
        again += keeper.answer == Answer::kAgain ? 1 : 0;
    }
    void forget() { taken_.clear(); }

  private:
    std::vector<Step> taken_;
};

const std::vector<Link>& links() {
    static const std::vector<Link> all = [] {
        std::vector<Link> made;
        for (const Pacing pacing : {Pacing::kLockstep, Pacing::kFreeRunning}) {
            for (const auto& [pair_clocks, timeout_clocks] : {std::pair{2, 3}, {3, 2}, {1, 1}}) {
                made.push_back({pacing, pair_clocks, timeout_clocks});
            }
        }
        return made;
    }();
    return all;
}

Step good_pair(std::uint32_t number, bool asks) {
    Step step;
    step.event.pair_good = true;
    step.event.number = number;
    step.asks = asks;
    return step;
}

Step colour() {
    Step step;
    step.event.colour_start = true;
    return step;
}

TEST_CASE("pair keeper: every sequence of four edges is answered as the rules say") {
    for (const Link& link : links()) {
        Stories stories;
        stories.check_all(Banks(link), 4);
        CHECK(stories.steps_taken > 20'000);
        CHECK(stories.fresh > 0);
        CHECK(stories.again > 0);
    }
}

TEST_CASE(
    "pair keeper: every sequence of four edges after a first pair or an overwritten one is answered as the "
    "rules say") {
    for (const Link& link : links()) {
        if (link.pair_clocks != 2) continue;  // one of each pacing
        Stories stories;
        Banks keeper(link);
        stories.take(keeper, colour());
        stories.take(keeper, good_pair(0, true));
        CHECK(keeper.story.wanted() == 1);
        stories.check_all(keeper, 4);
        stories.take(keeper, good_pair(1, false));
        stories.take(keeper, colour());
        stories.check_all(keeper, 4);
        CHECK(stories.fresh > 0);
        CHECK(stories.again > 0);
    }
}

TEST_CASE("pair keeper: long random sequences are answered as the rules say") {
    constexpr std::uint64_t kSeed = 20260;
    const std::uint64_t seed = test::random_seed(kSeed);
    INFO("METABUFFER_SEED=" << seed);
    test::Random random(seed);
    Stories stories;
    for (int story = 0; story < 2'000; ++story) {
        Banks keeper(
            links()[static_cast<std::size_t>(random.between(0, static_cast<int>(links().size()) - 1))]);
        for (int edge = 0; edge < 40; ++edge) {
            const std::vector<Step> possible = steps(keeper.story);
            // Now and then a reset, which is the first of them.
            const int first = random.one_in(30) ? 0 : 1;
            stories.take(keeper, possible[static_cast<std::size_t>(
                                     random.between(first, static_cast<int>(possible.size()) - 1))]);
        }
        stories.forget();
    }
    CHECK(stories.fresh > 1'000);
    CHECK(stories.again > 1'000);
}

TEST_CASE("pair keeper: a silent link is answered at the timeout, which the keeper announces in advance") {
    for (const Pacing pacing : {Pacing::kLockstep, Pacing::kFreeRunning}) {
        PairKeeper keeper(pacing, 10, 25);
        keeper.reset(100);
        CHECK_FALSE(keeper.next_timer(100));
        keeper.ask();
        // A colour frame begins in time, and nothing comes after it: it holds the timeout for a pair time.
        PairEvent event;
        event.colour_start = true;
        keeper.take(event, 120);
        CHECK(keeper.next_timer(120) == 125);
        CHECK_FALSE(keeper.answer(125));
        CHECK(keeper.next_timer(125) == 130);
        CHECK_FALSE(keeper.answer(129));
        CHECK(keeper.answer(130) == Answer::kAgain);
        CHECK_FALSE(keeper.next_timer(130));
        CHECK_FALSE(keeper.answer(131));
        // The next timeout counts from the answer.
        keeper.ask();
        CHECK(keeper.next_timer(130) == 155);
    }
}

}  // namespace
}  // namespace metabuffer
