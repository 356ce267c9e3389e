#include "tools/program/slurm_array.h"

#include <fmt/format.h>
#include <poll.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <fstream>
#include <iostream>
#include <iterator>
#include <map>
#include <optional>
#include <sstream>
#include <system_error>
#include <thread>

#include "host/errors.h"
#include "host/filter_process.h"
#include "host/output_file.h"
#include "host/text.h"
#include "tools/exploration/parts_folder.h"
#include "tools/exploration/results_merge.h"
#include "tools/program/progress_line.h"
#include "tools/program/stop_signals.h"

namespace metabuffer {
namespace {

constexpr const char* kJobsFile = "jobs";
constexpr const char* kMergeStatusFile = "merge.status";
constexpr const char* kMergeLog = "merge.log";
constexpr int kFirstPollMilliseconds = 1000;  // grows while jobs run
constexpr int kLastPollMilliseconds = 15'000;
/// Of the controller, which may be restarted while jobs go on.
constexpr std::chrono::minutes kLongestSilence{5};
/// One per second, since a shared disk may show a file late.
constexpr int kStatusTries = 60;

/// Runs a command of Slurm and returns what it prints. Throws OutputError.
std::string slurm(std::vector<std::string> command) {
    return filtered({std::move(command), "slurm-client", "sweep --slurm"}, "");
}

/// The text, quoted as one word of a shell's line.
std::string word(const std::string& text) {
    std::string quoted = "'";
    for (const char character : text)
        quoted += character == '\'' ? std::string("'\\''") : std::string(1, character);
    return quoted + "'";
}

/// A path for an option of sbatch in which a single % would begin a name of Slurm's.
std::string pattern(const std::filesystem::path& path) {
    std::string text;
    for (const char character : path.string())
        text += character == '%' ? std::string("%%") : std::string(1, character);
    return text;
}

/// "1,3-5".
std::string ranges(const std::vector<std::int64_t>& sorted) {
    std::string text;
    for (std::size_t n = 0; n < sorted.size();) {
        std::size_t last = n;
        while (last + 1 < sorted.size() && sorted[last + 1] == sorted[last] + 1) ++last;
        text += (text.empty() ? "" : ",") + std::to_string(sorted[n]);
        if (last > n) text += "-" + std::to_string(sorted[last]);
        n = last + 1;
    }
    return text;
}

std::optional<std::string> text_in(const std::filesystem::path& file) {
    std::ifstream stream(file);
    if (!stream) return std::nullopt;
    return std::string{std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
}

/// Slurm does not answer, perhaps only for a while.
class SlurmSilence : public OutputError {
  public:
    using OutputError::OutputError;
};

std::string queue() {
    try {
        return slurm({"squeue", "--me", "--noheader", "--array", "--format=%F %T"});
    } catch (const OutputError& error) {
        throw SlurmSilence(error.what());
    }
}

/// The jobs of one submission.
struct Jobs {
    std::string array = "-";  ///< "-": no shard was left to run
    std::string merge;
};

/// One sweep's jobs, and the folder that has its parts.
class SlurmArray {
  public:
    SlurmArray(const exploration::SweepPlan& plan, const SlurmRequest& request,
               const ProcessOptions& processes)
        : plan_(plan),
          request_(request),
          processes_(processes),
          results_(std::filesystem::absolute(request.results).lexically_normal()),
          parts_(std::filesystem::path(results_) += ".parts") {}

    ExitStatus run();

  private:
    std::optional<Jobs> jobs_at_work() const;
    std::vector<std::int64_t> shards_to_run() const;
    Jobs submit(const std::vector<std::int64_t>& shards) const;
    std::string submit(const std::vector<std::string>& options, const std::filesystem::path& script) const;
    std::string program_words() const;
    std::string shard_script() const;
    std::string merge_script() const;
    std::map<std::string, int> states_of(const Jobs& jobs) const;
    std::int64_t points_handed_in();
    void keep_earlier_results() const;
    ExitStatus wait_for(const Jobs& jobs, const StopSignals& signals);
    void check_site_options() const;
    ExitStatus outcome() const;

    const exploration::SweepPlan& plan_;
    const SlurmRequest& request_;
    const ProcessOptions& processes_;
    std::filesystem::path results_;
    std::filesystem::path parts_;
    std::map<std::filesystem::path, std::int64_t> counted_;  ///< points by file
};

/// The jobs of the last submission, if Slurm still has one of them.
std::optional<Jobs> SlurmArray::jobs_at_work() const {
    const std::optional<std::string> text = text_in(parts_ / kJobsFile);
    if (!text) return std::nullopt;
    Jobs jobs;
    std::string digest;
    std::int64_t shards = 0;
    std::istringstream words(*text);
    words >> digest >> shards >> jobs.array >> jobs.merge;
    if (states_of(jobs).empty()) return std::nullopt;
    if (digest == plan_.digest && shards == request_.shards && !jobs.merge.empty()) return jobs;
    throw InputError("jobs of another sweep, or of another number of shards, are at work for '" +
                     request_.results.string() + "' (" + text::one_line(*text) +
                     "); wait for them, or end them with scancel");
}

/// How many of the jobs are in which state. Jobs that have ended are not counted.
std::map<std::string, int> SlurmArray::states_of(const Jobs& jobs) const {
    std::map<std::string, int> states;
    std::istringstream lines(queue());
    std::string job;
    std::string state;
    while (lines >> job >> state) {
        if (job == jobs.array || job == jobs.merge) ++states[state];
    }
    return states;
}

void SlurmArray::check_site_options() const {
    static constexpr std::array<const char*, 10> kOwn{
        "--array", "-a", "--dependency", "-d", "--output", "-o", "--parsable", "--clusters", "-M", "--wrap"};
    for (const std::string& option : request_.site_options) {
        const std::string name = option.substr(0, option.find('='));
        if (option.front() != '-') {
            throw InputError("--sbatch: " + text::quoted(option) +
                             " is no option; use one like --sbatch=--partition=long");
        }
        if (std::find(kOwn.begin(), kOwn.end(), name) != kOwn.end()) {
            throw InputError("--sbatch: " + text::quoted(name) +
                             " is what --slurm chooses itself; leave it out");
        }
    }
}

/// Makes the results a part. Results without parts are of a sweep from which the parts have been removed.
void SlurmArray::keep_earlier_results() const {
    std::error_code error;
    if (!std::filesystem::exists(results_, error)) return;
    exploration::merge_results({results_}, parts_ / "earlier.db");
}

std::vector<std::int64_t> SlurmArray::shards_to_run() const {
    const exploration::ResultsIdentity identity = identity_of(plan_, processes_);
    // Checked now, not only when all jobs have ended.
    std::error_code error;
    if (std::filesystem::exists(results_, error)) exploration::check_belongs(results_, identity);
    std::optional<exploration::MissingPoints> missing =
        exploration::missing_in(parts_, identity, plan_.digest, request_.shards);
    if (!missing) {
        keep_earlier_results();
        missing = exploration::missing_in(parts_, identity, plan_.digest, request_.shards);
    }
    if (!missing) missing = exploration::all_missing(request_.shards);
    std::vector<std::int64_t> shards = missing->shards;
    shards.insert(shards.end(), missing->unfinished_shards.begin(), missing->unfinished_shards.end());
    std::sort(shards.begin(), shards.end());
    return shards;
}

std::string SlurmArray::program_words() const {
    const std::string program = std::filesystem::read_symlink("/proc/self/exe").string();
    return (request_.launcher.empty() ? "" : request_.launcher + " ") + word(program);
}

std::string SlurmArray::shard_script() const {
    // The sweep's file has the name that the user gave, since reasons of failed points contain it.
    std::string line = "exec " + program_words() + " sweep " + word(request_.sweep.string()) +
                       fmt::format(" --shard \"$SLURM_ARRAY_TASK_ID/{}\"", request_.shards) + " --parts " +
                       word(parts_.string()) + fmt::format(" --hand-in {}", request_.hand_in_seconds) +
                       " --level " + to_string(processes_.level);
    line += processes_.processes > 0 ? fmt::format(" --processes {}", processes_.processes)
                                     : std::string(" --processes \"${SLURM_CPUS_ON_NODE:-1}\"");
    if (processes_.time_limit_seconds > 0.0)
        line += " --time-limit " + text::number(processes_.time_limit_seconds);
    return "#!/bin/sh\n# exec, so that the signal that ends the job comes to the program.\n" + line + "\n";
}

std::string SlurmArray::merge_script() const {
    const std::string status = word((parts_ / kMergeStatusFile).string());
    return "#!/bin/sh\n" + program_words() + " merge " + word(parts_.string()) + " -o " +
           word(results_.string()) + "\nstatus=$?\necho $status >" + status + "\nexit $status\n";
}

std::string SlurmArray::submit(const std::vector<std::string>& options,
                               const std::filesystem::path& script) const {
    std::vector<std::string> command{"sbatch", "--parsable", "--open-mode=append",
                                     "--chdir=" + std::filesystem::current_path().string()};
    // sbatch uses the last of several equal options, so a site's option cannot replace these.
    command.insert(command.end(), request_.site_options.begin(), request_.site_options.end());
    command.insert(command.end(), options.begin(), options.end());
    command.push_back(script.string());
    std::string job = slurm(command);
    job.erase(std::min(job.find_first_of(";\n"), job.size()));
    return job;
}

Jobs SlurmArray::submit(const std::vector<std::int64_t>& shards) const {
    std::error_code error;
    std::filesystem::remove(parts_ / kMergeStatusFile, error);
    std::filesystem::remove(parts_ / kMergeLog, error);
    write_output_file(parts_ / "shard.sh", shard_script());
    write_output_file(parts_ / "merge.sh", merge_script());
    Jobs jobs;
    std::vector<std::string> merge_options{"--job-name=metabuffer-merge",
                                           "--output=" + pattern(parts_ / kMergeLog)};
    if (!shards.empty()) {
        jobs.array = submit({"--job-name=metabuffer-sweep", "--array=" + ranges(shards),
                             "--output=" + pattern(parts_) + "/shard-%a.log"},
                            parts_ / "shard.sh");
        merge_options.push_back("--dependency=afterany:" + jobs.array);
    }
    // Each job is recorded at once: a job without a record could not be found to be cancelled.
    const std::string known = fmt::format("{} {} {}", plan_.digest, request_.shards, jobs.array);
    write_output_file(parts_ / kJobsFile, known + "\n");
    try {
        jobs.merge = submit(merge_options, parts_ / "merge.sh");
    } catch (const OutputError&) {
        if (!shards.empty()) slurm({"scancel", jobs.array});
        throw;
    }
    write_output_file(parts_ / kJobsFile, known + " " + jobs.merge + "\n");
    return jobs;
}

/// Counts the points in all parts. A point that two jobs ran counts twice here, but not in the merge.
std::int64_t SlurmArray::points_handed_in() {
    std::int64_t points = 0;
    for (const std::filesystem::path& file : exploration::parts_in(parts_)) {
        try {
            const auto known = counted_.find(file);
            points += known != counted_.end()
                          ? known->second
                          : counted_.emplace(file, exploration::points_in(file)).first->second;
        } catch (const InputError&) {
            // The shared disk may not show all of it yet.
        }
    }
    return points;
}

ExitStatus SlurmArray::wait_for(const Jobs& jobs, const StopSignals& signals) {
    using Clock = std::chrono::steady_clock;
    const ProgressLine line(!request_.quiet);
    Clock::time_point last_answer = Clock::now();
    for (int milliseconds = kFirstPollMilliseconds;;
         milliseconds = std::min(milliseconds + milliseconds / 10, kLastPollMilliseconds)) {
        try {
            const std::map<std::string, int> states = states_of(jobs);
            last_answer = Clock::now();
            if (states.empty()) return outcome();
            std::vector<std::string> words;
            words.reserve(states.size());
            for (const auto& [state, count] : states) words.push_back(std::to_string(count) + " " + state);
            line.show(fmt::format("{} points handed in; jobs: {}", points_handed_in(), text::listed(words)));
        } catch (const SlurmSilence& silence) {
            if (Clock::now() - last_answer > kLongestSilence) throw;
            line.show(silence.what());
        }
        pollfd stop{signals.descriptor(), POLLIN, 0};
        if (poll(&stop, 1, milliseconds) > 0) break;
    }
    std::vector<std::string> cancel{"scancel", jobs.merge};
    if (jobs.array != "-") cancel.push_back(jobs.array);
    slurm(cancel);
    std::error_code error;
    std::filesystem::remove(parts_ / kJobsFile, error);
    std::cerr << "stopped, and its jobs cancelled; the same command goes on from here\n";
    return kExitStopped;
}

/// The exit status of the job that merges. Prints what that job printed.
ExitStatus SlurmArray::outcome() const {
    std::optional<std::string> status;
    // A shared disk may show the file some time after the job has ended.
    for (int n = 0; n < kStatusTries && (!status || status->empty() || status->back() != '\n'); ++n) {
        if (n > 0) std::this_thread::sleep_for(std::chrono::seconds(1));
        status = text_in(parts_ / kMergeStatusFile);
    }
    const std::string log = (parts_ / kMergeLog).string();
    std::istringstream digits(status.value_or(""));
    int number = 0;
    if (!(digits >> number)) {
        throw OutputError("the jobs have ended without a merge; see '" + log + "' and '" +
                          (parts_ / "shard-*.log").string() + "'");
    }
    const std::string said = text_in(log).value_or("");
    if (number != kExitDone) {
        std::cerr << said;
    } else if (!request_.quiet) {
        std::cout << said;
    }
    return static_cast<ExitStatus>(number);
}

ExitStatus SlurmArray::run() {
    check_site_options();
    // Made before the first job, since a signal that ends this process must also cancel its jobs.
    const StopSignals signals;
    make_folder_of(parts_ / kJobsFile, "--out");
    std::optional<Jobs> jobs = jobs_at_work();
    if (jobs && !request_.quiet)
        std::cout << "jobs " << jobs->array << " and " << jobs->merge << " are at work already\n";
    if (!jobs) {
        const std::vector<std::int64_t> shards = shards_to_run();
        jobs = submit(shards);
        if (!request_.quiet) {
            if (!shards.empty()) {
                std::cout << "submitted " << text::counted(static_cast<std::int64_t>(shards.size()), "shard")
                          << " as job " << jobs->array << '\n';
            }
            std::cout << "the merge is job " << jobs->merge << "; parts and logs are in "
                      << (std::filesystem::path(request_.results) += ".parts").string() << std::endl;
        }
    }
    return request_.waits ? wait_for(*jobs, signals) : kExitDone;
}

}  // namespace

ExitStatus run_on_slurm(const exploration::SweepPlan& plan, const SlurmRequest& request,
                        const ProcessOptions& processes) {
    return SlurmArray(plan, request, processes).run();
}

}  // namespace metabuffer
