/// loopline import FORMAT IN... --out F.rawlog: logs of other programs as rawlogs. Formats are Importer
/// classes of the plugins, and their parameters become options.
#include "commands/import.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <iostream>
#include <optional>

#include "api/trajectory.h"
#include "config/did_you_mean.h"
#include "config/ini_text.h"
#include "config/plugin_loader.h"
#include "output/output_file.h"
#include "output/rawlog_file.h"
#include "output/tum.h"

namespace loopline {
namespace {

namespace fs = std::filesystem;

/// "aperture_deg" as "--aperture-deg".
std::string option_name(std::string key) {
    std::replace(key.begin(), key.end(), '_', '-');
    return "--" + key;
}

/// What an importer writes and says.
class ImportSink : public RawlogSink {
 public:
    explicit ImportSink(RawlogFile& rawlog) : rawlog_(rawlog) {}
    void write(const mrpt::serialization::CSerializable& object) override { rawlog_.write(object); }
    void true_pose(StampNs stamp_ns, const Pose3& T_map_base) override {
        truth_.append(truth_.size(), stamp_ns, T_map_base, Matrix6d::Zero());
    }
    void true_frame(const EarthFrame& frame) override { frame_ = frame; }
    void warn(const std::string& sentence) override { std::cerr << "loopline: " << sentence << '\n'; }

    /// F.truth.tum, and F.truth.csv with the place of its frame, as the simulator writes them.
    void write_truth(const fs::path& rawlog) const {
        if (truth_.size() == 0) return;
        write_tum(fs::path(rawlog).replace_extension(".truth.tum"), truth_, Estimate::latest);
        if (!frame_) return;
        OutputFile csv(fs::path(rawlog).replace_extension(".truth.csv"));
        csv.text("kind,number,x_m,y_m,x2_m,y2_m,bottom_m,top_m\ngeoreference,0,")
            .number(frame_->latitude_deg)
            .text(",")
            .number(frame_->longitude_deg)
            .text(",")
            .number(frame_->height_m)
            .text(",")
            .number(frame_->heading_deg)
            .text("\n");
        csv.commit();
    }

 private:
    RawlogFile& rawlog_;
    Trajectory truth_;
    std::optional<EarthFrame> frame_;
};

class ImportCommand : public Command {
 public:
    std::string name() const override { return "import"; }
    std::string sentence() const override {
        return "Turns logs of other programs into rawlogs: carmen, csv, kitti, nmea";
    }

    void declare(CLI::App& app) override {
        app.require_subcommand(0, 1);
        app.allow_extras();  // an unknown format is answered by run()
        app_ = &app;
        // The plugins are loaded only when the command line asks for this command.
        app.preparse_callback([this, &app](std::size_t) { declare_formats(app); });
    }

    ExitCode run() override {
        if (!chosen_) refuse_format(app_->remaining());
        for (const auto& input : inputs_) {
            std::error_code ignored;
            if (!fs::is_regular_file(input, ignored) &&
                !(chosen_->takes_folders() && fs::is_directory(input, ignored)))
                throw CommandError(exit_input_data, "can't read " + input + ": there is no such file" +
                                                        (chosen_->takes_folders() ? " or folder" : ""));
            if (fs::equivalent(input, out_, ignored))
                throw CommandError(exit_configuration,
                                   "--out " + out_ + " is one of the inputs; give another file");
        }
        if (const std::string wrong = chosen_->check(); !wrong.empty())
            throw CommandError(exit_configuration, "import " + chosen_->info().name + ": " + wrong);
        RawlogFile rawlog(out_);
        ImportSink sink(rawlog);
        try {
            const std::string summary = chosen_->import(inputs_, sink);
            sink.write_truth(out_);
            rawlog.commit();
            std::cout << out_ << ": " << summary << '\n';
        } catch (const CommandError&) {
            throw;
        } catch (const std::runtime_error& e) {
            throw CommandError(exit_input_data, e.what());
        }
        return exit_done;
    }

 private:
    void declare_formats(CLI::App& app) {
        load_plugins();
        for (const auto& format : known_importers()) {
            const Importer::Ptr importer = make_importer(format);
            auto* sub = app.add_subcommand(format, importer->info().sentence);
            sub->allow_extras(false);  // which it inherits
            sub->add_option("IN", inputs_, "Files, taken one after the other")->required();
            sub->add_option("--out", out_, "The rawlog to write")->required()->type_name("F.rawlog");
            const ParameterTable table = importer->parameters();
            for (const auto& parameter : table.parameters())
                sub->add_option_function<std::string>(
                       option_name(parameter.name),
                       [parameter](const std::string& text) {
                           if (const auto wrong = parameter.parse(text))
                               throw CLI::ValidationError(option_name(parameter.name), text + " " + *wrong);
                       },
                       parameter.sentence + " (" + parameter_facts(parameter) + ")")
                    ->type_name("VALUE");
            sub->callback([this, importer] { chosen_ = importer; });
        }
    }

    [[noreturn]] static void refuse_format(const std::vector<std::string>& words) {
        const auto formats = known_importers();
        if (words.empty())
            throw CommandError(exit_configuration, "import needs a format; there is " + listing(formats));
        throw CommandError(exit_configuration,
                           "there is no format \"" + words[0] + "\" to import" +
                               did_you_mean(words[0], formats, "; there is " + listing(formats)));
    }

    CLI::App* app_ = nullptr;
    std::vector<std::string> inputs_;
    std::string out_;
    Importer::Ptr chosen_;
};

}  // namespace

std::unique_ptr<Command> make_import_command() {
    return std::make_unique<ImportCommand>();
}

}  // namespace loopline
