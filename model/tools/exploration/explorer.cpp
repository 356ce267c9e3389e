#include "tools/exploration/explorer.h"

#include <poll.h>
#include <zlib.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <deque>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <list>
#include <set>
#include <thread>
#include <utility>

#include "host/text.h"
#include "tools/exploration/expression.h"
#include "tools/exploration/figures.h"
#include "tools/exploration/goal.h"

namespace metabuffer::exploration {
namespace {

/// The name, as an input, of a sweep's only scenario, since its file may have any name. No path looks like this.
constexpr const char* kOnlyScenario = "(scenario)";

/// A file's size and checksum, used instead of its content.
std::string content_of(const std::filesystem::path& file) {
    std::ifstream stream(file, std::ios::binary);
    if (!stream) return "missing";
    const std::string bytes{std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
    const unsigned long crc = crc32_z(0, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size());
    return std::to_string(bytes.size()) + " bytes, CRC-32 " + std::to_string(crc);
}

/// Whether points that differ in this key may read different images or colour tables.
bool may_change_images(const std::string& key) {
    if (key == "frames" || key == "displays" || key.rfind("depth_", 0) == 0) return true;
    if (key.rfind("displays.correction", 0) == 0) return true;
    return key.rfind("renderers", 0) == 0 && key.find(".viewport") == std::string::npos &&
           key.find(".table") == std::string::npos && key.find(".copies") == std::string::npos;
}

/// A point's scenario, and those of its settings that may change the images that its run shows, as one text.
std::string image_settings(const std::filesystem::path& scenario, const Point& point) {
    std::vector<Setting> settings{{kScenarioAxis, scenario.string()}};
    std::copy_if(point.settings.begin(), point.settings.end(), std::back_inserter(settings),
                 [](const Setting& setting) { return may_change_images(setting.key); });
    return canonical_text(settings);
}

}  // namespace

double Progress::rate() const {
    return seconds > 0.0 ? static_cast<double>(points_ended - points_reused) / seconds : 0.0;
}

std::optional<double> Progress::seconds_to_go() const {
    if (rate() <= 0.0) return std::nullopt;
    return static_cast<double>(points - points_ended) / rate();
}

/// One run through a plan.
class Explorer::Session {
  public:
    Session(const Explorer& explorer, ResultsDatabase* results, const ExploreOptions& options);

    Exploration explore();

  private:
    /// A point that has begun.
    struct Job {
        std::size_t number = 0;         ///< in the plan
        std::vector<Setting> settings;  ///< of the point
        std::optional<SmallestValueSearch> search;
        int runs = 0;
        int under_way = 0;
        bool all_invalid = true;
        std::map<std::int64_t, std::int64_t> run_ids;        ///< of a search, by value
        std::map<std::int64_t, std::vector<Value>> figures;  ///< of its runs
        std::optional<PointRecord> failure;          ///< of a search: a run that says nothing about the goal
        std::map<std::int64_t, std::string> misses;  ///< of a search: what the goal misses there, by value
        std::string bounds;                          ///< of a search: which values are not tried, and why
    };
    using Jobs = std::list<Job>;

    /// A simulation to be started.
    struct Task {
        Jobs::iterator job;
        std::optional<std::int64_t> value;  ///< of a search
    };
    struct Active {
        Task task;
        std::unique_ptr<RunProcess> process;
    };

    const SweepPlan& plan() const { return *explorer_.plan_; }
    std::vector<Setting> settings_of(const Task& task) const;
    bool begin_point();
    void begin(Task task);
    void fill();
    bool stop_is_wanted() const;
    int poll_milliseconds() const;
    std::vector<Active> wait();
    void take(const std::vector<Active>& finished);
    void take(const Task& task, const RunRecord& record, std::optional<std::int64_t> known_run);
    void take_searched(const Task& task, const RunRecord& record, std::int64_t run);
    void queue_wanted(Jobs::iterator job);
    PointRecord outcome_of(const Job& job) const;
    void end_search(Jobs::iterator job);
    void add_figures(PointRecord& point) const;
    std::optional<PointRecord> begin_search(Job& job) const;
    void ended(std::size_t number, PointRecord record);
    void put_cost(RunRecord& record) const;
    std::string why_unmet(const Job& job) const;
    void report_progress();

    using Clock = std::chrono::steady_clock;

    const Explorer& explorer_;
    ResultsDatabase* results_;
    const ExploreOptions& options_;
    std::optional<Goal> goal_;
    std::optional<Expression> cost_;
    bool wants_wrong_pixels_ = false;  ///< goal or cost names them
    Clock::time_point started_ = Clock::now();
    PointSequence::Iterator next_point_;
    std::size_t next_number_ = 0;
    std::int64_t next_run_ = 1;  ///< the next run's id if there is no results file
    Jobs jobs_;
    std::deque<Task> queue_;
    std::vector<Active> active_;
    int processes_;                               ///< simulations at once
    std::map<std::size_t, PointRecord> records_;  ///< by number in the plan, if they are kept
    Outcomes outcomes_;
    Progress progress_;
    bool stopped_ = false;
};

Explorer::Session::Session(const Explorer& explorer, ResultsDatabase* results, const ExploreOptions& options)
    : explorer_(explorer),
      results_(results),
      options_(options),
      next_point_(plan().points.begin()),
      processes_(options.processes) {
    progress_.points = plan().points.size();
    if (!plan().cost.empty()) {
        const std::string search_key = plan().search ? plan().search->key : std::string();
        cost_.emplace(plan().cost, cost_names(plan().keys, search_key), "cost");
        wants_wrong_pixels_ = cost_->uses(kWrongPixels);
    }
    if (!plan().search) return;
    const SearchDescription& search = *plan().search;
    goal_.emplace(search.goal, goal_names(plan().keys, search.key), search.where);
    wants_wrong_pixels_ = wants_wrong_pixels_ || goal_->expression().uses(kWrongPixels);
}

Exploration Explorer::Session::explore() {
    fill();
    while (!active_.empty() && !stopped_) {
        const std::vector<Active> finished = wait();
        // The next ones simulate while this process takes in the results.
        if (!stopped_) fill();
        take(finished);
        if (!stopped_) fill();
    }
    Exploration exploration;
    exploration.points.reserve(records_.size());
    for (auto& [number, record] : records_) exploration.points.push_back(std::move(record));
    exploration.outcomes = std::move(outcomes_);
    exploration.progress = progress_;
    exploration.stopped = stopped_;
    return exploration;
}

/// Starts as many simulations as may run at once.
void Explorer::Session::fill() {
    while (static_cast<int>(active_.size()) < processes_) {
        if (!queue_.empty()) {
            const Task task = queue_.front();
            queue_.pop_front();
            begin(task);
        } else if (!begin_point()) {
            return;
        }
        // The results may hold many points already, which begin and end here without a wait.
        constexpr std::size_t kPointsBetweenPolls = 256;
        if (next_number_ % kPointsBetweenPolls == 0 && stop_is_wanted()) {
            stopped_ = true;
            return;
        }
    }
}

bool Explorer::Session::stop_is_wanted() const {
    pollfd stop{options_.stop_descriptor, POLLIN, 0};
    return poll(&stop, 1, 0) > 0;
}

/// Begins the next point. False if there is none left.
bool Explorer::Session::begin_point() {
    if (next_point_ == plan().points.end()) return false;
    std::vector<Setting> settings = (*next_point_).settings;
    ++next_point_;
    const std::size_t number = next_number_++;
    if (results_ != nullptr) {
        std::optional<PointRecord> known = results_->find_point(settings);
        if (known && is_final(known->status)) {
            ++progress_.points_reused;
            add_figures(*known);
            ended(number, std::move(*known));
            return true;
        }
    }
    const auto job = jobs_.emplace(jobs_.end());
    job->number = number;
    job->settings = std::move(settings);
    if (plan().search) {
        const std::optional<PointRecord> answer = begin_search(*job);
        if (answer) {
            if (results_ != nullptr) results_->add_point(*answer);
            ended(number, *answer);
            jobs_.erase(job);
            return true;
        }
        queue_wanted(job);
    } else {
        queue_.push_back({job, std::nullopt});
    }
    return true;
}

void Explorer::Session::queue_wanted(Jobs::iterator job) {
    for (const std::int64_t value : job->search->wanted()) {
        ++job->under_way;
        queue_.push_back({job, value});
    }
}

std::vector<Setting> Explorer::Session::settings_of(const Task& task) const {
    std::vector<Setting> settings = task.job->settings;
    if (task.value) settings.push_back({plan().search->key, plan().search->text_of(*task.value)});
    return settings;
}

void Explorer::Session::begin(Task task) {
    if (task.job->failure) {  // the point has failed meanwhile
        if (--task.job->under_way == 0) end_search(task.job);
        return;
    }
    const std::vector<Setting> settings = settings_of(task);
    if (results_ != nullptr) {
        const auto known = results_->find_run(settings);
        if (known && is_final(known->second.status)) {
            take(task, known->second, known->first);
            return;
        }
    }
    RunRequest request{explorer_.template_of(settings), plan().overrides_of(settings), settings,
                       plan().pictures, wants_wrong_pixels_};
    try {
        active_.push_back({task, std::make_unique<RunProcess>(explorer_.simulate_, std::move(request))});
    } catch (const InputError&) {
        // There are no more processes or descriptors: go on with those that run.
        if (active_.empty()) throw;
        processes_ = static_cast<int>(active_.size());
        queue_.push_front(task);
    }
}

/// Begins a search, without the values that are known to be of no use. Returns the point's record if no value can meet
/// the goal.
std::optional<PointRecord> Explorer::Session::begin_search(Job& job) const {
    SearchDescription search = *plan().search;
    const std::vector<Setting>& settings = job.settings;
    if (options_.known) {
        try {
            const KnownAnswer known =
                options_.known(explorer_.template_of(settings)->scenario(plan().overrides_of(settings)));
            if (!known.hopeless.empty()) {
                PointRecord point;
                point.settings = settings;
                point.status = RunStatus::kUnmet;
                point.reason = known.hopeless;
                point.runs = 0;
                return point;
            }
            job.bounds = narrow(search, known);
        } catch (const InputError&) {
            // The runs report what is wrong with the point.
        }
    }
    job.search.emplace(search);
    return std::nullopt;
}

/// Adds the figures to a point that the results hold: those of its run.
void Explorer::Session::add_figures(PointRecord& point) const {
    std::vector<Setting> settings = point.settings;
    if (plan().search) {
        if (!point.smallest) return;
        settings.push_back({plan().search->key, text::number(*point.smallest)});
    }
    auto run = results_->find_run(settings);
    if (run) point.figures = std::move(run->second.figures);
}

/// How long to wait for something to happen before the time limits are checked.
int Explorer::Session::poll_milliseconds() const {
    constexpr int kLimitMilliseconds = 100;
    constexpr int kTickMilliseconds = 1000;
    if (options_.time_limit_seconds > 0.0) return kLimitMilliseconds;
    return options_.on_tick ? kTickMilliseconds : -1;
}

/// Waits for something to happen, and returns the simulations that have ended.
std::vector<Explorer::Session::Active> Explorer::Session::wait() {
    std::vector<pollfd> waited;
    waited.reserve(active_.size() + 1);
    for (const Active& active : active_) waited.push_back({active.process->descriptor(), POLLIN, 0});
    // poll() ignores a negative descriptor.
    waited.push_back({options_.stop_descriptor, POLLIN, 0});
    if (poll(waited.data(), waited.size(), poll_milliseconds()) < 0) {
        if (errno == EINTR) return {};
        throw InputError("metabuffer: cannot wait for runs");
    }
    if (waited.back().revents != 0) {
        stopped_ = true;
        return {};
    }
    if (options_.on_tick) options_.on_tick();
    std::vector<Active> finished;
    for (std::size_t n = 0; n < active_.size(); ++n) {
        if (waited[n].revents != 0) {
            active_[n].process->receive();
        } else if (options_.time_limit_seconds > 0.0 &&
                   active_[n].process->seconds() > options_.time_limit_seconds) {
            active_[n].process->give_up("took longer than its time limit of " +
                                        text::number(options_.time_limit_seconds) + " s");
        }
        if (active_[n].process->ended()) finished.push_back(std::move(active_[n]));
    }
    active_.erase(std::remove_if(active_.begin(), active_.end(),
                                 [](const Active& active) { return active.process == nullptr; }),
                  active_.end());
    return finished;
}

void Explorer::Session::take(const std::vector<Active>& finished) {
    for (const Active& active : finished) {
        ++progress_.runs;
        RunRecord record = active.process->record();
        put_cost(record);
        take(active.task, record, std::nullopt);
    }
}

void Explorer::Session::take(const Task& task, const RunRecord& record,
                             std::optional<std::int64_t> known_run) {
    Job& job = *task.job;
    ++job.runs;
    if (job.search) {
        if (!known_run) known_run = results_ != nullptr ? results_->add_run(record) : next_run_++;
        take_searched(task, record, *known_run);
        return;
    }
    PointRecord point;
    point.settings = job.settings;
    point.status = record.status;
    point.reason = record.reason;
    point.run = known_run;
    point.figures = record.figures;
    if (results_ != nullptr) {
        if (known_run) {
            results_->add_point(point);
        } else {
            results_->add_point(point, record);
        }
    }
    ended(job.number, std::move(point));
    jobs_.erase(task.job);
}

/// Sets the cost as the sweep defines it, instead of that by the usual weights.
void Explorer::Session::put_cost(RunRecord& record) const {
    const std::size_t cost = figure_index(kCost).value();
    if (!cost_ || cost >= record.figures.size()) return;
    try {
        record.figures[cost] = cost_->evaluate(values_in(record));
    } catch (const InputError&) {
        record.figures[cost] = Value();  // it has none for this run
    }
}

void Explorer::Session::take_searched(const Task& task, const RunRecord& record, std::int64_t run) {
    Job& job = *task.job;
    --job.under_way;
    job.run_ids[*task.value] = run;
    job.figures[*task.value] = record.figures;
    job.all_invalid = job.all_invalid && record.status == RunStatus::kInvalid;
    if (record.status == RunStatus::kFailed || record.status == RunStatus::kCrashed) {
        // The run says nothing about the goal, so the search fails, too.
        PointRecord failure;
        failure.status = record.status;
        failure.reason = plan().search->setting_text(*task.value) + ": " + record.reason;
        failure.run = run;
        job.failure = std::move(failure);
    } else {
        const bool meets = goal_->is_met_by(record);
        if (!meets) job.misses[*task.value] = goal_->missed_by(record);
        job.search->take(*task.value, meets);
    }
    if (job.failure || job.search->finished()) {
        if (job.under_way == 0) end_search(task.job);
    } else {
        queue_wanted(task.job);
    }
    report_progress();
}

std::string Explorer::Session::why_unmet(const Job& job) const {
    const std::int64_t lowest = job.run_ids.begin()->first;
    const std::int64_t largest = job.run_ids.rbegin()->first;
    const SearchDescription& search = *plan().search;
    std::string missed = plan().search->setting_text(largest) + ": " + job.misses.at(largest);
    if (job.search->exhaustive() && lowest == largest) return missed;
    const std::string range = search.text_of(lowest) + " to " + search.text_of(largest);
    const std::string what = job.search->exhaustive() ? "no value of " + range + " meets the goal"
                                                      : "none of " + std::to_string(job.run_ids.size()) +
                                                            " values tried, " + range + ", meets the goal";
    return what + "; " + missed;
}

PointRecord Explorer::Session::outcome_of(const Job& job) const {
    if (job.failure) return *job.failure;
    PointRecord point;
    point.bounds = job.bounds;
    if (const std::optional<std::int64_t> smallest = job.search->smallest()) {
        point.smallest = plan().search->number_of(*smallest);
        point.run = job.run_ids.at(*smallest);
        point.figures = job.figures.at(*smallest);
        point.monotonic = job.search->monotonic();
        point.note = job.search->note([&job](std::int64_t value) { return job.misses.at(value); });
        return point;
    }
    point.run = job.run_ids.rbegin()->second;
    point.figures = job.figures.rbegin()->second;
    point.status = job.all_invalid ? RunStatus::kInvalid : RunStatus::kUnmet;
    point.reason = job.all_invalid ? job.misses.rbegin()->second : why_unmet(job);
    return point;
}

void Explorer::Session::end_search(Jobs::iterator job) {
    PointRecord point = outcome_of(*job);
    point.settings = job->settings;
    point.runs = job->runs;
    if (results_ != nullptr) results_->add_point(point);
    ended(job->number, std::move(point));
    jobs_.erase(job);
}

void Explorer::Session::ended(std::size_t number, PointRecord record) {
    outcomes_.add(number, record);
    if (options_.keeps_points) records_.emplace(number, std::move(record));
    ++progress_.points_ended;
    report_progress();
}

void Explorer::Session::report_progress() {
    progress_.seconds = std::chrono::duration<double>(Clock::now() - started_).count();
    if (options_.on_progress) options_.on_progress(progress_);
}

Explorer::Explorer(const SweepPlan& plan, Simulate simulate, bool needs_pixels)
    : plan_(&plan), simulate_(std::move(simulate)), needs_pixels_(needs_pixels || plan.pictures) {
    // Points that agree in all that may change images have the same ones.
    std::set<std::string> with_images;
    for (const Point& point : plan.points) {
        const std::filesystem::path file = plan.scenario_file(point.settings);
        const auto [known, is_new] = templates_.try_emplace(file);
        if (is_new) {
            known->second = std::make_shared<const ScenarioTemplate>(file);
            add_input(file == plan.scenario ? kOnlyScenario : name_of_input(file), file);
        }
        const std::string shown = image_settings(file, point);
        if (with_images.count(shown) != 0) continue;
        try {
            read_images_of(point, *known->second);
            with_images.insert(shown);
        } catch (const InputError&) {
            // The point's own run reports what is wrong.
        }
    }
}

/// Reads the images now, so that the runs' processes find them in memory.
void Explorer::read_images_of(const Point& point, const ScenarioTemplate& scenario) {
    const std::vector<ScenarioOverride> overrides = plan_->overrides_of(point.settings);
    for (const std::filesystem::path& file : scenario.input_files(overrides)) {
        add_input(name_of_input(file), file);
    }
    const Scenario made = scenario.scenario(overrides);
    if (needs_pixels_) read_images(made);
}

/// The file's path relative to the sweep, so that a copy of all files in another folder is the same input.
std::string Explorer::name_of_input(const std::filesystem::path& file) const {
    std::filesystem::path base = plan_->base.empty() ? plan_->scenario.parent_path() : plan_->base;
    if (base.empty()) base = ".";
    return std::filesystem::absolute(file)
        .lexically_normal()
        .lexically_proximate(std::filesystem::absolute(base).lexically_normal())
        .string();
}

void Explorer::add_input(const std::string& name, const std::filesystem::path& file) {
    if (inputs_.count(name) == 0) inputs_[name] = content_of(file);
}

ResultsIdentity Explorer::identity(const std::string& program_version, const std::string& level) const {
    ResultsIdentity identity;
    identity.name = plan_->name;
    identity.inputs = inputs_;
    identity.scenario = plan_->scenario.lexically_normal().string();
    identity.base = plan_->base.lexically_normal().string();
    for (const ScenarioOverride& setting : plan_->fixed)
        identity.fixed.push_back({setting.path, setting.value});
    identity.level = level;
    identity.fingerprint = "version " + program_version + (plan_->pictures ? "; pictures" : "");
    if (!plan_->cost.empty()) identity.fingerprint += "; cost " + plan_->cost;
    std::vector<std::string> fixed;
    for (const ScenarioOverride& setting : plan_->fixed) fixed.push_back(setting.path + "=" + setting.value);
    std::sort(fixed.begin(), fixed.end());
    for (const std::string& setting : fixed) identity.fingerprint += "; " + setting;
    identity.keys = plan_->keys;
    if (plan_->search) {
        const SearchDescription& search = *plan_->search;
        identity.fingerprint += "; from " + std::to_string(search.from) + " to " + std::to_string(search.to) +
                                ", checks " + std::to_string(search.checks);
        if (search.step > 0.0) identity.fingerprint += ", step " + text::number(search.step);
        for (const std::int64_t value : search.candidates)
            identity.fingerprint += " " + std::to_string(value);
        identity.search_key = search.key;
        identity.goal = search.goal;
    }
    return identity;
}

int usual_process_count() {
    // It returns 0 if the number is not known.
    return static_cast<int>(std::max(1U, std::thread::hardware_concurrency())) + 1;
}

Exploration Explorer::run(ResultsDatabase* results, const ExploreOptions& options) const {
    return Session(*this, results, options).explore();
}

const std::shared_ptr<const ScenarioTemplate>& Explorer::template_of(
    const std::vector<Setting>& settings) const {
    return templates_.at(plan_->scenario_file(settings));
}

}  // namespace metabuffer::exploration
