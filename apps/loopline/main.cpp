/// loopline: from a rawlog and an .ini to a trajectory, a map, pictures and figures. The table of its
/// commands.
#include <unistd.h>

#include <cstdio>
#include <iostream>

#include "commands/calibrate.h"
#include "commands/check.h"
#include "commands/command_line.h"
#include "commands/describe.h"
#include "commands/evaluate.h"
#include "commands/import.h"
#include "commands/render.h"
#include "commands/run.h"
#include "commands/simulate.h"
#include "commands/sweep.h"

int main(int argc, char** argv) {
    loopline::survive_closed_pipes();

    std::vector<std::unique_ptr<loopline::Command>> commands;
    commands.push_back(loopline::make_run_command());
    commands.push_back(loopline::make_sweep_command());
    commands.push_back(loopline::make_calibrate_command());
    commands.push_back(loopline::make_simulate_command());
    commands.push_back(loopline::make_evaluate_command());
    commands.push_back(loopline::make_render_command());
    commands.push_back(loopline::make_check_command());
    commands.push_back(loopline::make_describe_command());
    commands.push_back(loopline::make_import_command());
    const int code = loopline::run_command_line(commands, {argv + (argc > 0), argv + argc});
    std::cout.flush();
    std::fflush(nullptr);
    ::_exit(code);  // without tearing down a hundred libraries
}
