# SPDX-License-Identifier: Apache-2.0
# Completion of `mtf` in fish: candidates are what `mtf --complete` lists (completion.h).

function __mtf_complete
    set -l words (commandline -opc)
    set -l current (commandline -ct)
    set -l name (string match -r -- '^--[^=]*=' $current)
    for line in ($words[1] --complete $words[2..-1] "$current" 2>/dev/null </dev/null)
        if test -z "$line"
            __fish_complete_path (string replace -- "$name" '' $current) | string replace -r '^' -- "$name"
        else
            printf '%s\n' "$name$line"
        end
    end
end
complete -c mtf -f -a '(__mtf_complete)'
