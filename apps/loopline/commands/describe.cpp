#include "commands/describe.h"

#include <CLI/CLI.hpp>
#include <iostream>

#include "commands/terminal.h"
#include "config/catalogue.h"
#include "config/did_you_mean.h"
#include "config/ini_text.h"

namespace loopline {
namespace {

class DescribeCommand : public Command {
 public:
    std::string name() const override { return "describe"; }
    std::string sentence() const override { return "Lists the modules, and explains the keys of each"; }

    void declare(CLI::App& app) override {
        app.add_option("name", name_, "A module, map builder or section; all of them if none is named")
            ->type_name("NAME");
        auto* ini = app.add_flag("--ini", ini_, "Print a commented .ini with the defaults");
        app.add_flag("--markdown", markdown_, "Print pages of the manual")->excludes(ini);
    }

    ExitCode run() override {
        const Catalogue catalogue;
        std::cout << (name_.empty() ? all_of(catalogue) : one_of(catalogue));
        return exit_done;
    }

 private:
    std::string all_of(const Catalogue& catalogue) const {
        if (ini_) return describe_all_as_ini(catalogue);
        return markdown_ ? describe_all_as_markdown(catalogue)
                         : describe_all_as_text(catalogue, terminal_width());
    }

    std::string one_of(const Catalogue& catalogue) const {
        const auto* entry = catalogue.find(name_);
        if (!entry)
            throw CommandError(
                exit_configuration,
                "there is no module, map builder or section \"" + name_ + "\"" +
                    did_you_mean(name_, catalogue.names(), "; there are " + listing(catalogue.names())));
        if (ini_) return ini_section_text(entry->table);
        return markdown_ ? describe_as_markdown(*entry) : describe_as_text(*entry, terminal_width());
    }

    std::string name_;
    bool ini_ = false, markdown_ = false;
};

}  // namespace

std::unique_ptr<Command> make_describe_command() {
    return std::make_unique<DescribeCommand>();
}

}  // namespace loopline
