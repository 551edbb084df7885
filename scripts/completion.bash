# Tab completion for Bash: `source scripts/completion.bash`. Pass types and options of restirpg come from the program itself, the
# Python programs answer through argcomplete.
_restirpg()
{
    local program=${COMP_WORDS[0]} before=${COMP_WORDS[COMP_CWORD - 1]} word=${COMP_WORDS[COMP_CWORD]} words= files=
    if ((COMP_CWORD == 1)); then
        words="render describe graph devices view --help --version"
    elif [[ $word == -* ]]; then
        words=$("$program" "${COMP_WORDS[1]}" --help 2>/dev/null | grep -oE -- '--?[a-z][a-z-]*')
    else
        case $before in
            --output) words="image variance invalid albedo normal depth" ;;
            --backend) words="software rayquery" ;;
            --scene) files='*.@(glb|gltf)' ;;
            describe) words=$("$program" describe 2>/dev/null | sed -n 's/^\([A-Za-z]*\): .*/\1/p') ;;
            graph | render) files='*.@(py|json)' ;;
            *) files='*' ;;
        esac
    fi
    mapfile -t COMPREPLY < <(compgen -W "$words" -- "$word"; [[ -z $files ]] || { shopt -s extglob; compgen -f -X "!$files" -- "$word"; compgen -d -- "$word"; })
}
complete -o filenames -F _restirpg restirpg build/bin/restirpg
for _program in compare make_scenes reproduce see_guide view; do
    command -v register-python-argcomplete >/dev/null && eval "$(register-python-argcomplete "$_program.py" "scripts/$_program.py")"
done
unset _program
