//! `paracal`: calibrates parallel mechanisms from the command line. The program is [`paracal::cli`].

fn main() -> std::process::ExitCode {
    paracal::cli::main()
}
