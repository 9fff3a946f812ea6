//! `supple-web-bindgen FILE.wasm FOLDER`: the module that loads FILE, its types, and the wasm itself, as supple.* in FOLDER.

use wasm_bindgen_cli_support::Bindgen;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [input, folder] = &arguments[..] else {
        return Err("which file, and which folder? supple-web-bindgen FILE.wasm FOLDER".into());
    };
    let mut bindgen = Bindgen::new();
    bindgen
        .input_path(input)
        .out_name("supple")
        .typescript(true)
        // Names of functions are a tenth of the file.
        .remove_name_section(true)
        .remove_producers_section(true);
    bindgen.web(true)?.generate(folder)?;
    Ok(())
}
