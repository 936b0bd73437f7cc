/// The order in which modules see observations, and what the recorder keeps.
#include <gtest/gtest.h>
#include <mrpt/obs/CObservationComment.h>

#include "pipeline/log_source.h"
#include "pipeline/module_chain.h"
#include "pipeline/recorder.h"
#include "pipeline_logs.h"

using namespace loopline;
using namespace loopline::testing;

namespace {

using Journal = std::vector<std::string>;

/// Writes down what it sees as "name:label@sequence", and publishes label + "." + name on what it was told
/// to.
class Scribe : public Module {
 public:
    Scribe() = default;
    Scribe(std::string name, Journal& journal, int publications, std::vector<std::string> takes_back = {})
        : name_(std::move(name)),
          journal_(&journal),
          publications_(publications),
          takes_back_(std::move(takes_back)) {}
    ModuleInfo info() const override { return {name_, "", {}, {}, {}, takes_back_}; }
    ParameterTable parameters() override { return {name_, ""}; }
    void process(const StreamItem& item, Publisher& publisher) override {
        note(item.observation->sensorLabel + "@" + std::to_string(item.sequence));
        for (int i = 0; i < publications_; ++i)
            publisher.publish(scan(item.stamp_ns + 1000, item.observation->sensorLabel + "." + name_));
    }
    void drain(Publisher& publisher) override {
        note("drain");
        if (publications_ > 0) publisher.publish(scan(5'000'000'000, "late." + name_), 3);
    }
    void finish(Results& results) override {
        note("finish");
        results.metrics["last"] = name_;
    }
    mrpt::rtti::CObject* clone() const override { return new Scribe(*this); }

 private:
    void note(const std::string& what) { journal_->push_back(name_ + ":" + what); }
    std::string name_;
    Journal* journal_ = nullptr;
    int publications_ = 0;
    std::vector<std::string> takes_back_;
};

StreamItem item_of(std::uint64_t sequence, const std::string& label) {
    const StampNs stamp_ns = 1'000'000'000 + static_cast<StampNs>(sequence) * 1'000'000;
    return {sequence, stamp_ns, scan(stamp_ns, label)};
}

}  // namespace

TEST(ModuleChain, each_module_sees_an_item_and_then_what_was_published_on_it) {
    Journal journal, heard;
    ModuleChain chain({std::make_shared<Scribe>("a", journal, 1), std::make_shared<Scribe>("b", journal, 1),
                       std::make_shared<Scribe>("c", journal, 0)},
                      nullptr,
                      [&](const StreamItem& item) { heard.push_back(item.observation->sensorLabel); });
    chain.process(item_of(7, "x"));
    EXPECT_EQ(journal, (Journal{"a:x@7", "b:x@7", "b:x.a@7", "c:x@7", "c:x.b@7", "c:x.a@7", "c:x.a.b@7"}));
    EXPECT_EQ(heard, (Journal{"x.a", "x.b", "x.a.b"}));
    EXPECT_EQ(chain.timings()[0].calls, 1u);
    EXPECT_EQ(chain.timings()[2].calls, 4u);
    EXPECT_GE(chain.timings()[2].total_ms, chain.timings()[2].worst_ms);
}

TEST(ModuleChain, what_is_asked_back_comes_when_the_item_has_passed_and_only_once) {
    Journal journal;
    ModuleChain chain({std::make_shared<Scribe>("a", journal, 1, Journal{"x.b", "x.b.a.b", "late.b"}),
                       std::make_shared<Scribe>("b", journal, 1), std::make_shared<Scribe>("c", journal, 0)});
    chain.process(item_of(7, "x"));
    EXPECT_EQ(journal, (Journal{"a:x@7", "b:x@7", "b:x.a@7", "c:x@7", "c:x.b@7", "c:x.a@7", "c:x.a.b@7",
                                "a:x.b@7", "b:x.b.a@7", "c:x.b.a@7", "c:x.b.a.b@7"}));
    journal.clear();
    chain.process(item_of(8, "y"));
    EXPECT_EQ(journal.size(), 7U) << "nothing is left over";
    journal.clear();
    Results results;
    chain.finish(results);
    EXPECT_EQ(journal, (Journal{"a:drain", "b:late.a@3", "c:late.a@3", "c:late.a.b@3", "b:drain",
                                "c:late.b@3", "a:late.b@3", "b:late.b.a@3", "c:late.b.a@3", "c:late.b.a.b@3",
                                "c:drain", "a:finish", "b:finish", "c:finish"}));
}

TEST(ModuleChain, drains_in_chain_order_then_finishes) {
    Journal journal;
    ModuleChain chain({std::make_shared<Scribe>("a", journal, 1), std::make_shared<Scribe>("b", journal, 0)});
    Results results;
    chain.finish(results);
    EXPECT_EQ(journal, (Journal{"a:drain", "b:late.a@3", "b:drain", "a:finish", "b:finish"}));
    EXPECT_EQ(std::get<std::string>(results.metrics["last"]), "b");
}

TEST(ModuleChain, several_publications_keep_their_order) {
    Journal journal;
    ModuleChain chain({std::make_shared<Scribe>("a", journal, 2), std::make_shared<Scribe>("b", journal, 0)});
    chain.process(item_of(0, "x"));
    chain.process(item_of(1, "y"));
    EXPECT_EQ(journal,
              (Journal{"a:x@0", "b:x@0", "b:x.a@0", "b:x.a@0", "a:y@1", "b:y@1", "b:y.a@1", "b:y.a@1"}));
}

TEST(Recorder, what_was_published_reads_back_as_a_log) {
    Folder folder;
    Recorder recorder(folder.path() / "run", {"CObservation2DRangeScan", "comments", "CObservationImage"});
    EXPECT_FALSE(std::filesystem::exists(folder / "run"))
        << "nothing is written before there is something to write";
    mrpt::obs::CObservationComment comment, other;
    comment.sensorLabel = "comments";
    comment.text = "kept for its label";
    other.sensorLabel = "other";
    recorder.take(*scan(1'000'000'000, "anything"));
    recorder.take(comment);
    recorder.take(other);
    EXPECT_FALSE(std::filesystem::exists(folder / "run/recorded.rawlog"));
    const auto warnings = recorder.commit();
    ASSERT_EQ(warnings.size(), 1u);
    EXPECT_NE(warnings[0].find("CObservationImage"), std::string::npos);
    EXPECT_FALSE(std::filesystem::exists(folder / "run/recorded.rawlog.part"));
    LogSource source({folder / "run/recorded.rawlog"});
    StreamItem item;
    ASSERT_TRUE(source.next(item));
    EXPECT_EQ(item.observation->sensorLabel, "anything");
    EXPECT_EQ(item.stamp_ns, 1'000'000'000);
    ASSERT_TRUE(source.next(item));
    EXPECT_EQ(dynamic_cast<const mrpt::obs::CObservationComment&>(*item.observation).text,
              "kept for its label");
    EXPECT_FALSE(source.next(item));
}

TEST(Recorder, leaves_nothing_half_written_behind) {
    Folder folder;
    {
        Recorder recorder(folder.path(), {"LASER"});
        recorder.take(*scan(1'000'000'000));
        EXPECT_TRUE(std::filesystem::exists(folder / "recorded.rawlog.part"));
    }
    EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}
