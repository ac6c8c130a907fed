//! Prints the page of all commands: `docs/commands.md` is its output.

fn main() {
    print!("{}", dcb_programs::command_page::page());
}
